#include "common/channel/secure_channels.h"

#include <algorithm>
#include <cassert>
#include <type_traits>
#include <utility>

#include "common/model/rng.h"

namespace padr::node {
namespace {

/// Between two Hellos to one place.
constexpr Micros kGreetAgain = 100'000;
/// The same to somebody whom we knew and have not heard for kQuiet.
constexpr Micros kGreetQuiet = 1'000'000;
constexpr Micros kQuiet = 2'000'000;
/// A cookie is good for this long at its maker's, and then some; whoever has one counts on less.
constexpr Micros kCookieAge = 10'000'000;
constexpr Micros kCookieFresh = 5'000'000;
/// Whoever has been quiet for so long may be forgotten for somebody else.
constexpr Micros kForgettable = 60'000'000;

/// The number whose lower half this is, as near to the newest as can be.
std::uint64_t whole_number(std::uint64_t newest, std::uint32_t low) {
  constexpr std::uint64_t kRound = std::uint64_t{1} << 32U;
  const std::uint64_t near = (newest & ~(kRound - 1)) | low;
  if (near > newest && near - newest > kRound / 2 && near >= kRound) return near - kRound;
  if (near < newest && newest - near > kRound / 2) return near + kRound;
  return near;
}

std::uint64_t first_word(const wire::Key& key) {
  std::uint64_t v = 0;
  for (unsigned i = 0; i < 8; ++i) v |= std::uint64_t{key[i]} << (8 * i);
  return v;
}

}  // namespace

SecureChannels::SecureChannels(ChannelConfig config)
    : config_(std::move(config)),
      secret_(wire::derive_key(config_.seed, "secret")),
      public_(wire::public_key(secret_)),
      id_(wire::short_id(public_)),
      handshake_(wire::handshake_key(config_.session)),
      cookies_(wire::derive_key(config_.seed, "cookies")),
      nonces_(first_word(wire::derive_key(config_.seed, "nonces"))) {
  assert(config_.mode != wire::SealMode::kNone);
}

SecureChannels::Channel* SecureChannels::known(const PublicKey& key) {
  const auto it = std::find_if(channels_.begin(), channels_.end(), [&](const Channel& c) { return c.key == key; });
  return it == channels_.end() ? nullptr : &*it;
}

SecureChannels::Channel* SecureChannels::lately_at(const Endpoint& place, Micros local) {
  const auto it = std::find_if(channels_.begin(), channels_.end(), [&](const Channel& c) {
    return (same_place(c.at, place) || same_place(c.home, place)) &&
           (local - c.heard <= kQuiet || (c.cookie && local - c.baked <= kCookieFresh));
  });
  return it == channels_.end() ? nullptr : &*it;
}

std::optional<SecureChannels::Channel> SecureChannels::channel_to(const PublicKey& key, const Endpoint& at,
                                                                  Micros local) const {
  const auto keys = wire::pair_keys(config_.session, secret_, public_, key);
  if (!keys) return std::nullopt;
  Channel c;
  c.key = key;
  c.id = wire::short_id(key);
  c.keys = *keys;
  c.at = at.place();
  c.home = c.at;
  c.name = c.at;
  c.name.key = key;
  c.heard = local;
  return c;
}

std::list<SecureChannels::Channel>::iterator SecureChannels::quietest() {
  return std::min_element(channels_.begin(), channels_.end(),
                          [](const Channel& a, const Channel& b) { return a.heard < b.heard; });
}

bool SecureChannels::has_room(Micros local) {
  return channels_.size() < kMostChannels || local - quietest()->heard >= kForgettable;
}

SecureChannels::Channel& SecureChannels::keep(const Channel& c) {
  if (channels_.size() >= kMostChannels) channels_.erase(quietest());
  tell_keys(c);
  channels_.push_back(c);
  return channels_.back();
}

void SecureChannels::tell_keys(const Channel& c) {
  if (!config_.on_key || keys_told_ == config_.most_keys) return;
  ++keys_told_;
  config_.on_key(public_, c.key, c.keys.out);
  config_.on_key(c.key, public_, c.keys.in);
}

// Those whom we were told of come in by force: their number is that of the session's slots and of who has been there.
SecureChannels::Channel* SecureChannels::make(const PublicKey& key, const Endpoint& at, Micros local) {
  auto c = channel_to(key, at, local);
  return c ? &keep(*c) : nullptr;
}

// ---- out

void SecureChannels::send(const Endpoint& to, PeerId state_to, std::span<const std::byte> datagram, Micros local) {
  Channel* c = nullptr;
  if (to.has_key()) {
    c = known(to.key);
    if (c == nullptr) c = make(to.key, to, local);
    if (c == nullptr) return;
    c->name = to;
    if (!c->met) c->at = c->home = to.place();
  } else {
    c = lately_at(to, local);
    if (c == nullptr) return call(to, state_to, datagram, local);
  }
  keep_company(*c, local);
  post(*c, state_to, datagram);
}

void SecureChannels::call(const Endpoint& to, PeerId state_to, std::span<const std::byte> datagram, Micros local) {
  auto it = std::find_if(callers_.begin(), callers_.end(), [&](const Caller& c) { return same_place(c.place, to); });
  if (it == callers_.end()) {
    if (callers_.size() >= kMostWaiting) callers_.pop_front();
    callers_.emplace_back().place = to.place();
    it = std::prev(callers_.end());
  }
  it->waiting = {to, state_to, wire::Bytes(datagram.begin(), datagram.end())};
  greet(it->place, it->nonce, it->greeted, kGreetAgain, local);
}

void SecureChannels::greet(const Endpoint& place, std::uint64_t& nonce, Micros& greeted, Micros pace, Micros local) {
  if (local - greeted < pace) return;
  greeted = local;
  // The same for as long as it is not answered: an answer that takes longer than the pace is an answer, too.
  while (nonce == 0) nonce = splitmix64(nonces_);
  outgoing_.add(place, kNoPeer, wire::encode_handshake(wire::Hello{public_, nonce}, handshake_));
}

void SecureChannels::introduce(Channel& to) {
  const wire::Introduction i{public_, ++number_, *to.cookie};
  outgoing_.add(to.at, kNoPeer, wire::encode_handshake(i, to.keys.out));
}

// It may not know us yet, or not any more.
void SecureChannels::keep_company(Channel& c, Micros local) {
  if (c.met && local - c.heard <= kQuiet) return;
  // Where we were told that it is, whoever may have led us elsewhere since.
  c.home = c.name.place();
  c.here = 0;
  if (c.cookie && local - c.baked <= kCookieFresh) {
    if (local - c.greeted < kGreetAgain) return;
    c.greeted = local;
    return introduce(c);
  }
  c.cookie.reset();
  greet(c.at, c.nonce, c.greeted, c.met ? kGreetQuiet : kGreetAgain, local);
}

void SecureChannels::post(Channel& to, PeerId state_to, std::span<const std::byte> datagram) {
  wire::seal_with(to.keys.out, config_.mode, id_, ++number_, datagram, sealed_);
  outgoing_.add(to.at, state_to, sealed_);
  // If both of two are led astray, neither gets what would put the other right.
  if (!same_place(to.home, to.at)) outgoing_.add(to.home, state_to, sealed_);
}

// ---- in

std::optional<SecureChannels::Arrival> SecureChannels::drop(ChannelDrop why) {
  ++stats_.dropped[static_cast<std::size_t>(why)];
  return std::nullopt;
}

std::optional<SecureChannels::Arrival> SecureChannels::receive(const Endpoint& place,
                                                               std::span<const std::byte> datagram, Micros local) {
  ++stats_.datagrams;
  if (const auto sealed = wire::read_sealed(datagram)) {
    ChannelDrop why = ChannelDrop::kStranger;
    for (Channel& c : channels_) {
      if (c.id != sealed->id) continue;
      const std::uint64_t number = whole_number(c.window.newest(), sealed->number);
      if (!c.window.would_pass(number)) {
        why = ChannelDrop::kReplay;
        continue;
      }
      if (!wire::unseal_with(c.keys.in, number, datagram, unsealed_)) {
        why = ChannelDrop::kTag;
        continue;
      }
      heard(c, place, number, local);
      ++stats_.passed;
      note_mode(c, sealed->mode);
      return Arrival{c.name, unsealed_};
    }
    return drop(why);
  }
  if (wire::is_handshake(datagram)) {
    const auto message = wire::decode_handshake(datagram, handshake_);
    if (!message) return drop(ChannelDrop::kTag);
    std::visit(
        [&](const auto& m) {
          using Type = std::decay_t<decltype(m)>;
          if constexpr (std::is_same_v<Type, wire::Hello> || std::is_same_v<Type, wire::Cookie>)
            take(place, m, local);
          else
            take(place, m, datagram, local);
        },
        *message);
    return std::nullopt;
  }
  wire::SealError error{};
  return drop(wire::open(datagram, error) ? ChannelDrop::kUnsealed : ChannelDrop::kForm);
}

// Only the newest says where somebody is: what was under way when it moved comes from where it was.
void SecureChannels::heard(Channel& c, const Endpoint& place, std::uint64_t number, Micros local) {
  const bool newest = number > c.window.newest();
  c.window.pass(number);
  if (newest && !same_place(c.at, place)) {
    if (c.met) ++stats_.moves;
    c.at = place.place();
    c.here = 0;
  }
  if (newest && c.here < kSettled && ++c.here == kSettled) c.home = c.at;
  c.met = true;
  c.heard = local;
}

void SecureChannels::note_mode(Channel& c, wire::SealMode mode) {
  if (config_.mode != wire::SealMode::kEncrypt || mode == wire::SealMode::kEncrypt) return;
  ++stats_.readable;
  if (!std::exchange(c.readable, true)) readable_.push_back(c.name);
}

wire::Tag SecureChannels::cookie_for(const Endpoint& place, const PublicKey& key, std::int64_t age) const {
  wire::Bytes text;
  for (const std::uint8_t b : place.address) text.push_back(static_cast<std::byte>(b));
  for (unsigned i = 0; i < 16; i += 8) text.push_back(static_cast<std::byte>(place.port >> i));
  for (const std::uint8_t b : key) text.push_back(static_cast<std::byte>(b));
  for (unsigned i = 0; i < 64; i += 8) text.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(age) >> i));
  return wire::tag_of(cookies_, text);
}

void SecureChannels::take(const Endpoint& place, const wire::Hello& hello, Micros local) {
  ++stats_.handshakes;
  const wire::Cookie c{public_, hello.nonce, cookie_for(place, hello.key, local / kCookieAge)};
  outgoing_.add(place.place(), kNoPeer, wire::encode_handshake(c, handshake_));
}

void SecureChannels::take(const Endpoint& place, const wire::Cookie& cookie, Micros local) {
  Parcel waiting;
  Channel* c = known(cookie.key);
  const auto caller = std::find_if(callers_.begin(), callers_.end(), [&](const Caller& k) {
    return k.nonce == cookie.nonce && same_place(k.place, place);
  });
  if (caller != callers_.end()) {
    waiting = std::move(caller->waiting);
    callers_.erase(caller);
    if (c == nullptr) c = make(cookie.key, place, local);
    if (c == nullptr) return;
    if (!c->met) c->at = c->home = place.place();
  } else if (c == nullptr || c->nonce == 0 || c->nonce != cookie.nonce) {
    drop(ChannelDrop::kCookie);
    return;
  }
  ++stats_.handshakes;
  c->nonce = 0;
  c->cookie = cookie.cookie;
  c->baked = local;
  c->greeted = local;
  introduce(*c);
  if (!waiting.bytes.empty()) post(*c, waiting.state_to, waiting.bytes);
}

bool SecureChannels::proven(const Channel& c, std::uint64_t number, std::span<const std::byte> datagram) {
  const bool is_new = c.window.would_pass(number);
  if (is_new && wire::proves(datagram, c.keys.in, number)) return true;
  drop(is_new ? ChannelDrop::kTag : ChannelDrop::kReplay);
  return false;
}

void SecureChannels::take(const Endpoint& place, const wire::Introduction& in, std::span<const std::byte> datagram,
                          Micros local) {
  const std::int64_t age = local / kCookieAge;
  if (!wire::same(in.cookie, cookie_for(place, in.key, age)) &&
      !wire::same(in.cookie, cookie_for(place, in.key, age - 1))) {
    drop(ChannelDrop::kCookie);
    return;
  }
  Channel* c = known(in.key);
  std::optional<Channel> fresh;
  if (c == nullptr) {
    if (has_room(local)) fresh = channel_to(in.key, place, local);
    if (!fresh) {
      drop(ChannelDrop::kFull);
      return;
    }
  }
  if (!proven(c != nullptr ? *c : *fresh, in.number, datagram)) return;
  if (fresh) {
    // Whatever it has sent before was to somebody here who knew it and has forgotten it.
    fresh->window.start_after(in.number);
    c = &keep(*fresh);
  }
  heard(*c, place, in.number, local);
  ++stats_.handshakes;
  const wire::Acceptance a{public_, ++number_};
  outgoing_.add(c->at, kNoPeer, wire::encode_handshake(a, c->keys.out));
}

void SecureChannels::take(const Endpoint& place, const wire::Acceptance& in, std::span<const std::byte> datagram,
                          Micros local) {
  Channel* c = known(in.key);
  if (c == nullptr) {
    drop(ChannelDrop::kStranger);
    return;
  }
  if (!proven(*c, in.number, datagram)) return;
  heard(*c, place, in.number, local);
  ++stats_.handshakes;
}

}  // namespace padr::node
