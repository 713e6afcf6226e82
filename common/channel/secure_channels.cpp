#include "common/channel/secure_channels.h"

#include <algorithm>
#include <cassert>
#include <span>
#include <type_traits>
#include <utility>

namespace padr::node {
namespace {

/// Between two Hellos to one place.
constexpr Micros kGreetAgain = 100'000;
/// The same to somebody whom we knew and have not heard for kQuiet.
constexpr Micros kGreetQuiet = 1'000'000;
/// What follows within this time goes by one way only, where it is not known which works: 5 ticks.
constexpr Micros kClosely = 80'000;
/// Whoever has a cookie counts on less than its maker does.
constexpr Micros kCookieFresh = 5'000'000;

/// The number whose lower half this is, as near to the newest as can be.
std::uint64_t whole_number(std::uint64_t newest, std::uint32_t low) {
  constexpr std::uint64_t kRound = std::uint64_t{1} << 32U;
  const std::uint64_t near = (newest & ~(kRound - 1)) | low;
  if (near > newest && near - newest > kRound / 2 && near >= kRound) return near - kRound;
  if (near < newest && newest - near > kRound / 2) return near + kRound;
  return near;
}

}  // namespace

SecureChannels::SecureChannels(ChannelConfig config)
    : config_(std::move(config)),
      secret_(wire::derive_key(config_.seed, "secret")),
      public_(wire::public_key(secret_)),
      id_(wire::short_id(public_)),
      handshake_(wire::handshake_key(config_.session)),
      cookies_(wire::derive_key(config_.seed, "cookies")) {
  assert(config_.mode != wire::SealMode::kNone && config_.random && config_.seed != wire::Key{});
  wire::wipe(std::as_writable_bytes(std::span<std::uint8_t>(config_.seed)));
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

bool SecureChannels::hears(const Endpoint& place, Micros local) const {
  return std::any_of(channels_.begin(), channels_.end(),
                     [&](const Channel& c) { return same_place(c.at, place) && c.met && local - c.heard <= kQuiet; });
}

// ---- out

void SecureChannels::send(const Endpoint& to, PeerId state_to, std::span<const std::byte> datagram, Micros local) {
  local_ = local;
  Channel* c = nullptr;
  if (to.has_key()) {
    c = known(to.key);
    if (c == nullptr) c = make(to.key, to, local);
    if (c == nullptr) return;
    c->name = to;
    if (state_to != kNoPeer) {
      c->number = state_to;
      c->hearsay = false;  // the address of a member does not change
    }
    if (!c->met) c->at = c->home = to.place();
  } else {
    c = lately_at(to, local);
    if (c == nullptr) return call(to, state_to, datagram, local);
  }
  keep_company(*c, local);
  post(*c, state_to, datagram);
  renew(*c, local);
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
  while (nonce == 0) config_.random(std::as_writable_bytes(std::span(&nonce, 1)));
  outgoing_.add(place, kNoPeer, wire::encode_handshake(wire::Hello{public_, nonce}, handshake_));
}

// It may not know us yet, or not any more.
void SecureChannels::keep_company(Channel& c, Micros local) {
  if (c.met && local - c.heard <= kQuiet) return;
  // Where we were told that it is, whoever may have led us elsewhere since.
  c.home = c.name.place();
  c.here = 0;
  if (!c.answers) c.at = c.home;  // it has not answered from there
  c.answers = true;
  if (c.cookie && local - c.baked <= kCookieFresh) {
    if (local - c.greeted < kGreetAgain) return;
    c.greeted = local;
    return introduce(c, local);
  }
  c.cookie.reset();
  greet(c.at, c.nonce, c.greeted, c.met ? kGreetQuiet : kGreetAgain, local);
}

// Where it is not known which way works, both are tried: with each datagram, or in turn where those of states follow
// closely, as they do to whoever has fallen silent.
void SecureChannels::post(Channel& to, PeerId state_to, std::span<const std::byte> datagram) {
  const bool is_state = state_to != kNoPeer;
  const bool closely = is_state && local_ - std::exchange(to.posted, local_) < kClosely;
  const bool in_turn = closely && is_carried(to) && to.directly_too;
  to.turn = in_turn && !to.turn;
  wire::seal_with(to.keys.out(), config_.mode, id_, ++number_, datagram, sealed_);
  if (in_turn && to.turn) return transmit_directly(to, state_to, sealed_);
  transmit(to, state_to, sealed_);
  if (is_carried(to) && !in_turn) try_directly(to, state_to, datagram);
}

// Sealed anew: what comes second of two with one number would be dropped, and the receiver not know that it came.
void SecureChannels::try_directly(Channel& to, PeerId state_to, std::span<const std::byte> datagram) {
  if (!to.directly_too) {
    if (state_to == kNoPeer || local_ - to.tried < to.try_again) return;
    to.tried = local_;
    to.try_again = std::min(2 * to.try_again, kTrySlowest);
    for (const Endpoint& place : to.elsewhere) {
      Micros never = kNever;
      if (!same_place(place, to.at)) greet(place, to.nonce, never, kGreetAgain, local_);
    }
  }
  wire::seal_with(to.keys.out(), config_.mode, id_, ++number_, datagram, sealed_);
  transmit_directly(to, state_to, sealed_);
}

void SecureChannels::carry(const PublicKey& to, const PublicKey& by, bool directly_too, Micros local,
                           std::span<const Endpoint> elsewhere) {
  Channel* c = known(to);
  if (c == nullptr) return;
  if (local >= c->carried_until) {
    c->tried = local;
    c->try_again = kTryAgain;
  }
  c->carrier = by;
  c->carried_until = local + kCarries;
  c->directly_too = directly_too;
  c->elsewhere.assign(elsewhere.begin(), elsewhere.end());
}

void SecureChannels::expect(const Endpoint& somebody, Micros since, Micros local) {
  local_ = local;
  Channel* c = known(somebody.key);
  if (c == nullptr && has_room(local)) {
    c = make(somebody.key, somebody, local);
    if (c != nullptr) c->hearsay = true;
  }
  if (c != nullptr && !c->met && local - since <= kKnocks) greet(c->at, c->nonce, c->greeted, kKnockAgain, local);
}

SecureChannels::Came SecureChannels::came(const PublicKey& of, Micros local) const {
  for (const Channel& c : channels_)
    if (c.key == of) return {c.mutual && local - c.direct <= kQuiet, local - c.carried <= kQuiet};
  return {};
}

Endpoint SecureChannels::place(const PublicKey& of) const {
  for (const Channel& c : channels_)
    if (c.key == of) return c.at;
  return {};
}

void SecureChannels::transmit(Channel& to, PeerId state_to, std::span<const std::byte> sealed) {
  Channel* by = is_carried(to) ? known(to.carrier) : nullptr;
  if (by == nullptr) return transmit_directly(to, state_to, sealed);
  wire::encode_carried({to.id, sealed}, carried_);
  wire::seal_with(by->keys.out(), config_.mode, id_, ++number_, carried_, outer_);
  transmit_directly(*by, by->number, outer_);
}

void SecureChannels::transmit_directly(Channel& to, PeerId state_to, std::span<const std::byte> sealed) {
  if (may_send_there(to, sealed.size())) outgoing_.add(to.at, state_to, sealed);
  // If both of two are led astray, neither gets what would put the other right.
  if (!same_place(to.home, to.at)) outgoing_.add(to.home, state_to, sealed);
}

// ---- in

std::optional<SecureChannels::Arrival> SecureChannels::drop(ChannelDrop why) {
  ++stats_.dropped[static_cast<std::size_t>(why)];
  return std::nullopt;
}

std::optional<SecureChannels::Arrival> SecureChannels::receive(const Endpoint& place,
                                                               std::span<const std::byte> datagram, Micros local) {
  local_ = local;
  ++stats_.datagrams;
  return open(&place, datagram);
}

std::optional<SecureChannels::Arrival> SecureChannels::open(const Endpoint* place,
                                                            std::span<const std::byte> datagram) {
  const auto sealed = wire::read_sealed(datagram);
  if (!sealed) return open_handshake(place, datagram);
  // Nobody carries what is carried already: there is one hop.
  if (sealed->kind == wire::Kind::kCarried && place == nullptr) return drop(ChannelDrop::kForm);
  ChannelDrop why = ChannelDrop::kStranger;
  for (Channel& c : channels_) {
    if (c.id != sealed->id) continue;
    const std::uint64_t number = whole_number(c.window.newest(), sealed->number);
    if (!c.window.would_pass(number)) {
      why = ChannelDrop::kReplay;
      continue;
    }
    const auto opens = [&](const wire::Key& key) { return wire::unseal_with(key, number, datagram, unsealed_); };
    if (!c.keys.open(opens, local_)) {
      why = ChannelDrop::kTag;
      continue;
    }
    heard(c, place, number, datagram.size(), local_);
    note_mode(c, sealed->mode);
    renew(c, local_);
    if (sealed->kind == wire::Kind::kCarried) return take_carried(c);
    ++stats_.passed;
    return Arrival{c.name, unsealed_, place == nullptr};
  }
  return drop(why);
}

std::optional<SecureChannels::Arrival> SecureChannels::take_carried(const Channel& by) {
  const auto carried = wire::decode_carried(unsealed_);
  if (!carried) return drop(ChannelDrop::kForm);
  if (carried->to != id_) {
    pass_on(by, carried->to);
    return std::nullopt;
  }
  carried_.assign(carried->sealed.begin(), carried->sealed.end());
  return open(nullptr, carried_);
}

// As it came, and not to who says that it does not hear this peer. That this peer does not hear it proves nothing:
// their link may work in this direction only.
void SecureChannels::pass_on(const Channel& by, std::uint32_t to) {
  for (Channel& c : channels_) {
    if (c.id != to || &c == &by) continue;
    const bool reached = !is_carried(c) || c.directly_too;
    if (!reached || !config_.may_carry || !config_.may_carry(by.name, c.name, unsealed_.size())) {
      ++stats_.declined;
      continue;
    }
    wire::seal_with(c.keys.out(), config_.mode, id_, ++number_, unsealed_, sealed_);
    ++stats_.carried;
    stats_.carried_bytes += sealed_.size();
    transmit_directly(c, c.number, sealed_);
  }
}

std::optional<SecureChannels::Arrival> SecureChannels::open_handshake(const Endpoint* place,
                                                                      std::span<const std::byte> datagram) {
  if (!wire::is_handshake(datagram)) {
    wire::SealError error{};
    return drop(wire::open(datagram, error) ? ChannelDrop::kUnsealed : ChannelDrop::kForm);
  }
  const auto message = wire::decode_handshake(datagram, handshake_);
  if (!message) return drop(ChannelDrop::kTag);
  return std::visit(
      [&](const auto& m) -> std::optional<Arrival> {
        using Type = std::decay_t<decltype(m)>;
        if constexpr (std::is_same_v<Type, wire::Acceptance> || std::is_same_v<Type, wire::Rekey>) {
          take(place, m, datagram, local_);
        } else if (place == nullptr) {  // the others are about an address
          return drop(ChannelDrop::kForm);
        } else if constexpr (std::is_same_v<Type, wire::Introduction>) {
          take(*place, m, datagram, local_);
        } else {
          take(*place, m, local_);
        }
        return std::nullopt;
      },
      *message);
}

void SecureChannels::heard(Channel& c, const Endpoint* place, std::uint64_t number, std::size_t bytes, Micros local) {
  const bool newest = number > c.window.newest();
  c.window.pass(number);
  c.heard = local;
  c.in_vain = 0;
  count_rekeys(c);
  if (place != nullptr) {
    note_place(c, *place, newest, bytes, local);
    if (local - c.direct > kQuiet) c.try_again = kTryAgain;  // what works again one way may do so both ways
    c.direct = local;
  } else {
    c.carried = local;
  }
  c.met = true;
}

// Only the newest says where somebody is: what was under way when it moved comes from where it was.
void SecureChannels::note_place(Channel& c, const Endpoint& place, bool newest, std::size_t bytes, Micros local) {
  if (newest && !same_place(c.at, place)) {
    if (c.met) ++stats_.moves;
    c.at = place.place();
    c.here = 0;
    c.mutual = false;
    c.answers = same_place(c.home, place);  // where it has answered before, or where we were told that it is
    c.credit = 0;
    c.nonce = 0;
    c.greeted = kNever;
  }
  if (same_place(c.at, place)) c.credit += c.answers ? 0 : kUnprovenTimes * bytes;
  if (newest && c.here < kSettled && c.answers && ++c.here == kSettled) c.home = c.at;
  if (!c.answers) challenge(c, local);
}

// The sender's address in a datagram proves nothing: whoever has recorded it can send it first, from anywhere.
void SecureChannels::challenge(Channel& c, Micros local) {
  if (local - c.greeted >= kGreetAgain && may_send_there(c, wire::kHandshakeBytes))
    greet(c.at, c.nonce, c.greeted, kGreetAgain, local);
}

// It has echoed what was sent there.
void SecureChannels::answered(Channel& c, const Endpoint& place) {
  if (!same_place(c.at, place)) return;
  c.answers = c.mutual = true;
  if (std::exchange(c.hearsay, false)) {
    c.name.address = place.address;
    c.name.port = place.port;
  }
}

bool SecureChannels::may_send_there(Channel& c, std::size_t bytes) {
  if (c.answers) return true;
  if (c.credit < bytes) return false;
  c.credit -= bytes;
  return true;
}

void SecureChannels::note_mode(Channel& c, wire::SealMode mode) {
  if (config_.mode != wire::SealMode::kEncrypt || mode == wire::SealMode::kEncrypt) return;
  ++stats_.readable;
  if (!std::exchange(c.readable, true)) readable_.push_back(c.name);
}

}  // namespace padr::node
