// What SecureChannels does so that two peers get to know one another's keys, and get new ones as time goes on.
#include <algorithm>
#include <utility>

#include "common/channel/secure_channels.h"

namespace padr::node {
namespace {

/// So many introductions by later keys than the first are answered by nothing before a peer goes back to the first.
constexpr int kInVain = 10;

}  // namespace

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
  // It answers where it has said that it is: the link there works, the one to `at` does not.
  if (is_carried(*c) &&
      std::any_of(c->elsewhere.begin(), c->elsewhere.end(), [&](const Endpoint& e) { return same_place(e, place); })) {
    c->at = place.place();
    c->here = 0;
  }
  answered(*c, place);
  c->cookie = cookie.cookie;
  c->baked = local;
  c->greeted = local;
  introduce(*c, local);
  if (!waiting.bytes.empty()) post(*c, waiting.state_to, waiting.bytes);
}

void SecureChannels::introduce(Channel& to, Micros local) {
  // It is there, but it has not answered to these keys: it may have lost them.
  if (to.keys.generation() > 0 && ++to.in_vain > kInVain) to.keys.restart(local);
  const wire::Introduction i{public_, ++number_, *to.cookie};
  outgoing_.add(to.at, kNoPeer, wire::encode_handshake(i, to.keys.out()));
}

void SecureChannels::accept(Channel& to) {
  const wire::Acceptance a{public_, ++number_};
  transmit(to, kNoPeer, wire::encode_handshake(a, to.keys.out()));
}

bool SecureChannels::proven(Channel& c, std::uint64_t number, std::span<const std::byte> datagram, Micros local) {
  const bool is_new = c.window.would_pass(number);
  const auto opens = [&](const wire::Key& key) { return wire::proves(datagram, key, number); };
  if (is_new && c.keys.open(opens, local)) return true;
  drop(is_new ? ChannelDrop::kTag : ChannelDrop::kReplay);
  return false;
}

// A peer that has made room for another one here, or has lost its keys otherwise, comes with the first keys. The
// introduction has to be its newest datagram: an old one that comes late takes nobody back.
bool SecureChannels::introduced(Channel& c, std::uint64_t number, std::span<const std::byte> datagram, Micros local) {
  if (c.keys.generation() > 0 && !c.keys.may_lag(local) && number > c.window.newest() &&
      wire::proves(datagram, c.keys.first().in, number)) {
    c.keys.restart(local);
    return true;
  }
  return proven(c, number, datagram, local);
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
  if (!introduced(c != nullptr ? *c : *fresh, in.number, datagram, local)) return;
  if (fresh) {
    // Whatever it has sent before was to somebody here who knew it and has forgotten it.
    fresh->window.start_after(in.number);
    c = &keep(*fresh);
  }
  heard(*c, &place, in.number, datagram.size(), local);
  answered(*c, place);  // the cookie in it was sent there
  ++stats_.handshakes;
  // Either shows that the introduction has come.
  const auto rekey = c->answers ? c->keys.due(local, config_.random) : std::nullopt;
  rekey ? tell(*c, *rekey) : accept(*c);
}

void SecureChannels::take(const Endpoint* place, const wire::Acceptance& in, std::span<const std::byte> datagram,
                          Micros local) {
  Channel* c = known(in.key);
  if (c == nullptr) {
    drop(ChannelDrop::kStranger);
    return;
  }
  if (!proven(*c, in.number, datagram, local)) return;
  heard(*c, place, in.number, datagram.size(), local);
  ++stats_.handshakes;
}

// ---- new keys

void SecureChannels::renew(Channel& c, Micros local) {
  if (!c.met || !c.answers) return;
  if (const auto rekey = c.keys.due(local, config_.random)) tell(c, *rekey);
}

void SecureChannels::tell(Channel& to, wire::Rekey rekey) {
  rekey.number = ++number_;
  rekey.id = id_;
  transmit(to, kNoPeer, wire::encode_handshake(rekey, to.keys.out()));
}

void SecureChannels::take(const Endpoint* place, const wire::Rekey& in, std::span<const std::byte> datagram,
                          Micros local) {
  ChannelDrop why = ChannelDrop::kStranger;
  for (Channel& c : channels_) {
    if (c.id != in.id) continue;
    c.keys.forget(local);
    const wire::Key* key = c.keys.key_of(in.generation);
    if (!c.window.would_pass(in.number)) {
      why = ChannelDrop::kReplay;
    } else if (key == nullptr || !wire::proves(datagram, *key, in.number)) {
      why = ChannelDrop::kTag;
    } else {
      heard(c, place, in.number, datagram.size(), local);
      ++stats_.handshakes;
      return follow(c, in, local);
    }
  }
  drop(why);
}

void SecureChannels::count_rekeys(Channel& c) {
  stats_.rekeys += c.keys.rekeys() - std::exchange(c.rekeys, c.keys.rekeys());
}

void SecureChannels::follow(Channel& c, const wire::Rekey& in, Micros local) {
  const auto answer = c.keys.take(in, local, config_.random);
  count_rekeys(c);
  if (answer.made) tell_keys(c.key, *answer.made);
  if (answer.rekey) tell(c, *answer.rekey);
  if (answer.confirm) accept(c);
}

}  // namespace padr::node
