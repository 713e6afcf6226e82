#include "common/wire/session_codec.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <string_view>

#include "common/wire/endpoint_codec.h"
#include "proto/wire.pb.h"

namespace padr::wire {
namespace {

/// A ping, even one sent at 0, which takes no bytes, must not be smaller than any pong.
constexpr std::size_t kPingPadding = 18;

std::string printable(std::string_view text, std::size_t limit) {
  std::string s(text.substr(0, limit));
  std::replace_if(
      s.begin(), s.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return s;
}

bool is_clock(Micros t) {
  return t >= -kMaxClock && t <= kMaxClock;
}

// ---- out

/// Pads to `size` bytes in all. From 128 bytes up both lengths around the padding take two bytes to write.
template <typename Message>
void pad(const Session& out, Message& message, std::size_t size) {
  constexpr std::size_t kLeast = 128;
  message.set_padding(std::string(kLeast, '\0'));
  const std::size_t least_size = out.ByteSizeLong();
  assert(least_size <= size);
  message.set_padding(std::string(kLeast + size - least_size, '\0'));
}

template <typename Message>
void put(const Whereabouts& w, Message& message) {
  message.mutable_in()->Assign(w.in.begin(), w.in.end());
  message.mutable_seeks()->Assign(w.seeks.begin(), w.seeks.end());
}

struct Encoder {
  Session& out;

  void operator()(const Join& m) const {
    auto& j = *out.mutable_join();
    j.set_nonce(m.nonce);
    j.set_scene_hash(m.scene_hash);
    j.set_fingerprint(m.fingerprint);
    j.set_authority(m.authority);
    j.set_scenario(printable(m.scenario, kMaxLabel));
    j.set_spectator(m.spectator);
    pad(out, j, kMaxPayload);
  }
  void operator()(const Welcome& m) const {
    auto& w = *out.mutable_welcome();
    w.set_nonce(m.nonce);
    w.set_peer(m.peer);
    w.set_slots(static_cast<std::uint32_t>(m.slots));
    w.set_wanted(static_cast<std::uint32_t>(m.wanted));
    w.set_incarnation(m.incarnation);
    w.set_cookie(m.cookie);
    if (m.session != SessionId{}) w.set_session(std::string(m.session.begin(), m.session.end()));
  }
  void operator()(const Redirect& m) const {
    auto& r = *out.mutable_redirect();
    r.set_nonce(m.nonce);
    put_endpoint(m.to, r);
  }
  void operator()(const Refuse& m) const {
    out.mutable_refuse()->set_nonce(m.nonce);
    out.mutable_refuse()->set_reason(printable(m.reason, kMaxReason));
  }
  void operator()(const Ping& m) const {
    out.mutable_ping()->set_sent_us(m.sent);
    out.mutable_ping()->set_padding(std::string(kPingPadding, '\0'));
  }
  void operator()(const Pong& m) const {
    out.mutable_pong()->set_sent_us(m.sent);
    out.mutable_pong()->set_session_us(m.session);
  }
  void operator()(const Ask& m) const {
    auto& a = *out.mutable_ask();
    a.set_nonce(m.nonce);
    a.set_crowd(m.crowd);
    a.set_about(m.about);
    put(m.sender, a);
    a.set_rank(m.rank);
    pad(out, a, kAskPayload);
  }
  void operator()(const Tell& m) const {
    auto& t = *out.mutable_tell();
    t.set_nonce(m.nonce);
    t.set_crowd(m.crowd);
    t.set_about(m.about);
    put(m.sender, t);
    t.set_rank(m.rank);
    t.set_clock_us(m.clock);
    t.set_noted(m.noted);
    for (const Acquaintance& k : m.known) {
      auto& known = *t.add_known();
      put_endpoint(k.at.place(), known);
      put(k.where, known);
    }
  }
};

// ---- in

std::optional<SessionMessage> take(const Session::Join& in) {
  if (in.nonce() == 0 || in.scenario().size() > kMaxLabel) return std::nullopt;
  return Join{in.nonce(),    in.scene_hash(), in.fingerprint(), in.authority(), printable(in.scenario(), kMaxLabel),
              in.spectator()};
}

std::optional<SessionMessage> take(const Session::Welcome& in) {
  constexpr std::uint32_t most = kMaxPeers;
  if (in.slots() > most || in.wanted() == 0 || in.wanted() > in.slots() || in.peer() >= in.slots()) return std::nullopt;
  if (in.incarnation() == 0 || in.cookie() == 0) return std::nullopt;
  SessionId session{};
  if (!in.session().empty()) {
    if (in.session().size() != session.size()) return std::nullopt;
    std::copy(in.session().begin(), in.session().end(), session.begin());
    if (session == SessionId{}) return std::nullopt;
  }
  return Welcome{in.nonce(),
                 static_cast<PeerId>(in.peer()),
                 static_cast<int>(in.slots()),
                 static_cast<int>(in.wanted()),
                 in.incarnation(),
                 in.cookie(),
                 session};
}

std::optional<SessionMessage> take(const Session::Redirect& in) {
  Redirect r{in.nonce(), {}};
  if (!take_endpoint(in, r.to)) return std::nullopt;
  return r;
}

std::optional<SessionMessage> take(const Session::Refuse& in) {
  if (in.reason().size() > kMaxReason) return std::nullopt;
  return Refuse{in.nonce(), printable(in.reason(), kMaxReason)};
}

std::optional<SessionMessage> take(const Session::Ping& in) {
  if (!is_clock(in.sent_us()) || in.padding().size() < kPingPadding) return std::nullopt;
  return Ping{in.sent_us()};
}

std::optional<SessionMessage> take(const Session::Pong& in) {
  if (!is_clock(in.sent_us()) || !is_clock(in.session_us())) return std::nullopt;
  return Pong{in.sent_us(), in.session_us()};
}

template <typename Message>
bool take_whereabouts(const Message& in, Whereabouts& out) {
  const auto take_column = [](const auto& from, std::vector<std::uint32_t>& to) {
    if (static_cast<std::size_t>(from.size()) > kMostRegions) return false;
    to.assign(from.begin(), from.end());
    return std::find(to.begin(), to.end(), 0U) == to.end();
  };
  return take_column(in.in(), out.in) && take_column(in.seeks(), out.seeks);
}

std::optional<SessionMessage> take(const Session::Ask& in) {
  Ask a{in.nonce(), in.crowd(), in.about(), {}, in.rank()};
  if (a.nonce == 0 || a.about == 0 || !take_whereabouts(in, a.sender)) return std::nullopt;
  return a;
}

std::optional<SessionMessage> take(const Session::Tell& in) {
  Tell t{in.nonce(), in.crowd(), in.about(), {}, in.rank(), in.clock_us()};
  if (t.nonce == 0 || t.about == 0 || !take_whereabouts(in, t.sender)) return std::nullopt;
  if (t.clock < 0 || t.clock > kMaxClock || static_cast<std::size_t>(in.known_size()) > kMostKnown) return std::nullopt;
  for (const auto& k : in.known()) {
    Acquaintance& known = t.known.emplace_back();
    if (!take_endpoint(k, known.at) || known.at.has_key()) return std::nullopt;
    if (!take_whereabouts(k, known.where)) return std::nullopt;
  }
  t.noted = in.noted();
  return t;
}

Bytes bytes_of(const Session& message) {
  Bytes bytes(message.ByteSizeLong());
  message.SerializeToArray(bytes.data(), static_cast<int>(bytes.size()));
  return bytes;
}

}  // namespace

Bytes encode_session(const SessionMessage& message) {
  Session out;
  std::visit(Encoder{out}, message);
  return bytes_of(out);
}

std::optional<Bytes> encode_tell_within(const Tell& tell, std::size_t most) {
  Session out;
  Encoder{out}(tell);
  auto& known = *out.mutable_tell()->mutable_known();
  while (out.ByteSizeLong() > most) {
    if (known.empty()) return std::nullopt;
    known.RemoveLast();
  }
  return bytes_of(out);
}

std::optional<SessionMessage> decode_session(std::span<const std::byte> payload) {
  Session in;
  if (!in.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) return std::nullopt;
  switch (in.kind_case()) {
    case Session::kJoin:
      return take(in.join());
    case Session::kWelcome:
      return take(in.welcome());
    case Session::kRedirect:
      return take(in.redirect());
    case Session::kRefuse:
      return take(in.refuse());
    case Session::kPing:
      return take(in.ping());
    case Session::kPong:
      return take(in.pong());
    case Session::kAsk:
      return take(in.ask());
    case Session::kTell:
      return take(in.tell());
    case Session::KIND_NOT_SET:
      break;
  }
  return std::nullopt;
}

}  // namespace padr::wire
