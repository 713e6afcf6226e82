// What somebody at an address that has proven nothing gets back, in bytes with IP and UDP headers.
#include <cstdio>

#include "common/wire/session_codec.h"
#include "tests/channel/two_peers.h"
#include "tests/membership/party.h"

namespace padr::test {
namespace {

constexpr double kHeaders = 28;

double answered(node::SecureChannels& channels, const wire::Bytes& d, Micros now) {
  channels.receive(place(66), d, now);
  double bytes = 0;
  for (const auto& p : channels.take_outgoing()) bytes += static_cast<double>(p.bytes.size()) + kHeaders;
  return bytes;
}

TEST(Amplification, NothingUnprovenGetsBackMoreThanItSent) {
  TwoPeers g;
  g.meet();
  const wire::Key h = wire::handshake_key(channel_config(1).session);
  const wire::Bytes join = wire::seal({wire::Kind::kSession, kNoPeer, 0}, wire::encode_session(wire::Join{}));
  const std::vector<std::pair<const char*, wire::Bytes>> all{
      {"Hello", wire::encode_handshake(wire::Hello{key_of(5), 1}, h)},
      {"Cookie", wire::encode_handshake(wire::Cookie{key_of(5), 1, {}}, h)},
      {"Introduction", wire::encode_handshake(wire::Introduction{key_of(5), 1, {}}, h)},
      {"Acceptance", wire::encode_handshake(wire::Acceptance{g.a.key(), 1}, h)},
      {"Rekey", wire::encode_handshake(wire::Rekey{key_of(5), 1'000, wire::short_id(g.a.key()), 2, 0}, h)},
      {"Rekey, replayed",
       [&] {
         Endpoint to_b = place(2);
         to_b.key = g.b.key();
         g.now += 131 * kMicrosPerSecond;
         g.a.send(to_b, kNoPeer, words("x"), g.now);
         wire::Bytes found;
         for (const auto& p : taken(g.a))
           if (wire::is_handshake(p.bytes) && p.bytes[3] == std::byte{5}) found = p.bytes;
         EXPECT_FALSE(found.empty());
         g.b.receive(place(1), found, g.now);
         EXPECT_EQ(taken(g.b).size(), 1U) << "its own";
         return found;
       }()},
      {"Hello, wrong tag", wire::encode_handshake(wire::Hello{key_of(5), 1}, key_of(9))},
      {"sealed, wrong tag", wire::seal_with(key_of(9), wire::SealMode::kAuth, wire::short_id(g.a.key()), 99, join)},
      {"sealed, unknown", wire::seal_with(key_of(9), wire::SealMode::kAuth, 1, 99, join)},
      {"replayed",
       [&] {
         wire::Bytes d = g.sealed("x");
         g.b.receive(place(1), d, g.now);
         return d;
       }()},
      {"unsealed Join", join},
      {"garbage", wire::Bytes(1200)}};
  taken(g.b);  // what it has said to its peer
  std::printf("  %-20s %6s %6s %6s\n", "from anywhere", "in", "out", "factor");
  for (const auto& [name, d] : all) {
    const double in = static_cast<double>(d.size()) + kHeaders;
    const double out = answered(g.b, d, g.now);
    std::printf("  %-20s %6.0f %6.0f %6.2f\n", name, in, out, out / in);
    EXPECT_LE(out, in) << name;
  }
}

// In a session without a key, which anybody may come into, by whatever its members say.
TEST(Amplification, WithoutAKeyNothingUnprovenGetsBackMoreThanItSentEither) {
  const Endpoint stranger = place(66);
  constexpr std::uint64_t kNonce = 77;
  double out = 0;
  const lab::VirtualNetworkConfig config = party_config(6, "delay 5ms", 5);
  Party party(config, [&](lab::VirtualNetwork& g) {
    g.on_start = [&](int, node::ParticipantConfig& c) {
      c.tamper = [&](node::Parcel p) {
        if (same_place(p.to, stranger)) out += static_cast<double>(p.bytes.size()) + kHeaders;
        return std::vector{std::move(p)};
      };
    };
  });
  party.run(4);
  ASSERT_TRUE(party.united()) << party.story();
  const std::uint16_t number = party.net().peer(0).session().number();
  constexpr PeerId kElsewhere = 9;  // a slot that nobody sits in
  const auto session = [&](const wire::SessionMessage& m) {
    return wire::seal({wire::Kind::kSession, kElsewhere, number}, wire::encode_session(m));
  };
  const auto membership = [&](const wire::MembershipMessage& m) {
    return wire::seal({wire::Kind::kMembership, kElsewhere, number}, wire::encode_membership(m));
  };
  const std::vector<std::pair<const char*, wire::Bytes>> all{
      {"Join", session(wire::Join{kNonce, scene_hash(config.scene), 1, config.technique.authority, config.scene.name})},
      {"Join, other physics", session(wire::Join{kNonce + 1, scene_hash(config.scene), 2, true, "x"})},
      {"Welcome", session(wire::Welcome{kNonce, 1, 2, 2, 7, 9})},
      {"Redirect", session(wire::Redirect{kNonce, stranger})},
      {"Refuse", session(wire::Refuse{kNonce, "no"})},
      {"Ping", session(wire::Ping{1})},
      {"Pong", session(wire::Pong{1, 2})},
      {"Pull", membership(wire::Pull{kNonce, 0, ~std::uint64_t{0}, 1})},
      {"Enter", membership(wire::Enter{kNonce})},
      {"Probe", membership(wire::Probe{99, {{kElsewhere, 99, 0}}, false, 99})},
      {"Poll", membership(wire::Poll{{{1, party.replica(1).config().incarnation, 0}}})},
      {"Newcomer", membership(wire::Newcomer{stranger})},
      {"Fetch", membership(wire::Fetch{1, party.replica(1).config().incarnation, 0})},
      {"state", wire::seal({wire::Kind::kState, kElsewhere, number}, wire::Bytes(30))}};
  std::printf("  %-20s %6s %6s %6s\n", "from anywhere", "in", "out", "factor");
  for (const auto& [name, d] : all) {
    out = 0;
    constexpr int kTimes = 20;
    for (int i = 0; i < kTimes; ++i) {
      party.net().inject(stranger, i % 2, d);
      party.run(0.05);
    }
    const double in = kTimes * (static_cast<double>(d.size()) + kHeaders);
    std::printf("  %-20s %6.0f %6.0f %6.2f\n", name, in, out, out / in);
    EXPECT_LE(out, in) << name;
  }
  // In a member's name, to the coordinator.
  out = 0;
  const wire::Bytes newcomer =
      wire::seal({wire::Kind::kMembership, 1, number}, wire::encode_membership(wire::Newcomer{stranger}));
  for (int i = 0; i < 20; ++i) {
    party.net().inject(party.net().place_of(1), 0, newcomer);
    party.run(0.05);
  }
  EXPECT_GT(out, 0) << "or nothing has been tested";
  EXPECT_LE(out, 20 * (static_cast<double>(newcomer.size()) + kHeaders));
  // Of a side that wins. Once, each Probe was worth ten Joins.
  std::vector<wire::Seat> many;
  for (PeerId p = kElsewhere; p < kElsewhere + 12; ++p) many.push_back({p, 90U + p, 0});
  const wire::Bytes winning = membership(wire::Probe{99, many, false, 120});
  const double one = static_cast<double>(winning.size()) + kHeaders;
  out = 0;
  party.net().inject(stranger, 1, winning);
  party.run(8);
  EXPECT_LE(out, one);
  for (int i = 0; i < 100; ++i) {
    party.net().inject(stranger, 1, winning);
    party.run(0.3);
  }
  party.run(8);
  EXPECT_GT(out, 1200) << "it is asked, at last";
  EXPECT_LE(out, 101 * one);
  EXPECT_TRUE(party.united()) << party.story();
}

}  // namespace
}  // namespace padr::test
