#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string_view>
#include <vector>

#include "common/channel/secure_channels.h"
#include "common/model/rng.h"
#include "common/wire/codec.h"

namespace padr::test {

/// 10.0.0.n:7000.
inline Endpoint place(int n) {
  return ipv4({10, 0, 0, static_cast<std::uint8_t>(n)}, 7000);
}

inline wire::Key key_of(std::uint64_t seed) {
  Rng rng(seed);
  wire::Key k{};
  for (auto& b : k) b = static_cast<std::uint8_t>(rng.below(256));
  return k;
}

/// What the system gives a program, from a seed. Copies go on with one generator, as processes of one system do.
inline node::RandomBytes random_bytes(std::uint64_t seed) {
  return [rng = std::make_shared<Rng>(seed)](std::span<std::byte> out) {
    for (std::byte& b : out) b = static_cast<std::byte>(rng->below(256));
  };
}

inline node::ChannelConfig channel_config(std::uint64_t seed, wire::SealMode mode = wire::SealMode::kAuth,
                                          std::uint64_t session = 1) {
  node::ChannelConfig c;
  c.session = key_of(session);
  c.seed = key_of(1000 + seed);
  c.random = random_bytes(2000 + seed);
  c.mode = mode;
  return c;
}

/// An unsealed datagram with this in it.
inline wire::Bytes words(std::string_view text) {
  wire::Bytes payload;
  for (const char c : text) payload.push_back(static_cast<std::byte>(c));
  return wire::seal({wire::Kind::kState, 3, 77}, payload);
}

/// What it wants to be sent, to keep.
inline std::vector<node::Parcel> taken(node::SecureChannels& channels) {
  const auto all = channels.take_outgoing();
  return {all.begin(), all.end()};
}

/// Two gates at the places 1 and 2, between which whoever tests carries everything.
struct TwoPeers {
  explicit TwoPeers(wire::SealMode mode = wire::SealMode::kAuth) : TwoPeers(mode, mode) {}
  TwoPeers(wire::SealMode of_a, wire::SealMode of_b) : a(channel_config(1, of_a)), b(channel_config(2, of_b)) {}
  node::SecureChannels a;
  node::SecureChannels b;
  Micros now = 1'000'000;
  std::vector<wire::Bytes> at_a;  ///< what has come out there, unsealed
  std::vector<wire::Bytes> at_b;
  std::vector<Endpoint> names;  ///< of whom it came from

  void take(node::SecureChannels& to, std::vector<wire::Bytes>& into, const Endpoint& from, const wire::Bytes& bytes) {
    if (auto arrival = to.receive(from, bytes, now)) {
      into.emplace_back(arrival->datagram.begin(), arrival->datagram.end());
      names.push_back(arrival->from);
    }
  }
  /// Until nobody has anything to say.
  void carry() {
    for (bool more = true; more;) {
      more = false;
      for (const auto& p : taken(a)) more = true, take(b, at_b, place(1), p.bytes);
      for (const auto& p : taken(b)) more = true, take(a, at_a, place(2), p.bytes);
    }
  }
  void say(std::string_view text) { a.send(place(2), kNoPeer, words(text), now); }
  /// `a` has said something to `b`, who knows it by now.
  void meet() {
    say("hello");
    carry();
    ASSERT_EQ(at_b.size(), 1U);
  }
  /// What `a` makes of this for `b`, not yet carried.
  wire::Bytes sealed(std::string_view text) {
    say(text);
    const auto out = taken(a);
    EXPECT_EQ(out.size(), 1U);
    return out.empty() ? wire::Bytes{} : out.front().bytes;
  }
  std::uint64_t dropped_at_b(node::ChannelDrop why) const { return b.stats().dropped[static_cast<std::size_t>(why)]; }
};

}  // namespace padr::test
