// A member, a former member, or whoever has the key claims to speak for a larger part of the session.
#include "common/membership/partition_merge.h"
#include "tests/hostile/liar.h"

namespace padr::test {
namespace {

/// What a peer says that gives way.
constexpr const char* kOutvoted = " on without us";

/// Peers of slots 4 to 11 that nobody has ever seen.
std::vector<wire::Seat> invented(PeerId liar, std::uint32_t incarnation) {
  std::vector<wire::Seat> seats{{liar, incarnation, 0}};
  for (PeerId p = 4; p < 12; ++p) seats.push_back({p, 5000U + p, 0});
  return seats;
}

TEST(Takeover, AMembersProbeWithInventedPeers) {
  for (const auto mode : {wire::SealMode::kAuth, wire::SealMode::kEncrypt}) {
    Trial t(4, 2, mode, 501);
    t.liar().send_too([&t](const wire::Header& h, PeerId) {
      const wire::Probe probe{t.incarnation(2), invented(2, t.incarnation(2)), false, 10'000};
      return std::vector<wire::Bytes>{
          wire::seal({wire::Kind::kMembership, 2, h.session}, wire::encode_membership(probe))};
    });
    t.party().run(6);
    EXPECT_FALSE(t.noted(kOutvoted)) << t.party().story();
    t.expect_no_harm();
  }
}

// It was a member, has been evicted, and comes back with a large following.
TEST(Takeover, AFormerMembersProbeWithInventedPeers) {
  for (const PeerId liar : {PeerId{0}, PeerId{3}}) {
    Trial t(4, liar, wire::SealMode::kAuth, 502);
    t.party().run(12);
    std::map<int, int> away{{t.person(liar), 1}};
    t.party().net().divide(away);
    t.party().run(8);
    ASSERT_TRUE(t.liar_is_out()) << t.party().story();
    t.liar().speak_of_others([liar](wire::MembershipMessage& m) {
      if (auto* probe = std::get_if<wire::Probe>(&m)) probe->members = invented(liar, probe->incarnation);
    });
    t.party().net().divide({});
    t.party().run(6);
    EXPECT_GT(t.liar().told, 0U);
    for (const PeerId p : t.honest()) EXPECT_FALSE(t.party().noted(t.person(p), kOutvoted)) << t.party().story();
    t.expect_no_harm();
  }
}

// In place of asking to come in, in its first datagram.
TEST(Takeover, WhoeverHasTheKeyAndNeverWasAMember) {
  Trial t(4, 3, wire::SealMode::kAuth, 503);
  const std::uint16_t session = t.replica(0).config().session;
  std::uint64_t told = 0;
  t.party().net().on_start = [&](int, node::ParticipantConfig& c) {
    c.tamper = [&](node::Parcel p) {
      const wire::Probe probe{1, {{1, 1, 0}, {6, 9, 0}, {7, 9, 0}, {8, 9, 0}, {9, 9, 0}, {10, 9, 0}}, false, 10'000};
      p.bytes = wire::seal({wire::Kind::kMembership, 9, session}, wire::encode_membership(probe));
      ++told;
      return std::vector<node::Parcel>{p};
    };
  };
  for (int by = 0; by < 4; ++by) t.party().net().start(by);
  t.party().run(6);
  EXPECT_GT(told, 20U);
  EXPECT_FALSE(t.noted(kOutvoted)) << t.party().story();
  for (const PeerId p : {PeerId{0}, PeerId{1}, PeerId{2}})
    EXPECT_EQ(t.party().net().peer(t.person(p)).incarnation(), 0) << t.party().story();
  t.expect_confirmed({0, 1, 2});
}

// It was cut off for what it sent, which proves nothing to others, and is senior to the one that is left of those who
// know. Once, each newcomer went over to it, to cut it off in turn.
TEST(Takeover, NewcomersDoNotGoOverToWhoWasCutOff) {
  Trial t(4, 2, wire::SealMode::kAuth, 504);
  t.party().run(12);
  // Its avatar goes about, so that it has much to lie about: each of the others must know by itself.
  t.liar().begin([&t](sync::StatePacket& p, PeerId) {
    t.liar().signs = false;
    for (sync::Bundle& b : p.updates)
      if (b.avatar) b.avatar->position.x += 0.5F;
  });
  t.party().run(10);
  ASSERT_TRUE(t.liar_is_out()) << t.party().story();
  ASSERT_TRUE(t.party().noted(t.person(3), "cut off")) << t.party().story();
  ASSERT_TRUE(t.replica(3).roster().is_senior(2, 3));
  for (const PeerId p : {PeerId{0}, PeerId{1}}) t.party().net().leave(t.person(p));
  t.party().run(2);
  const int late = t.party().net().start(t.person(3));
  t.party().run(15);
  EXPECT_TRUE(t.party().net().peer(late).playing()) << t.party().story();
  EXPECT_FALSE(t.party().noted(late, kOutvoted)) << t.party().story();
  EXPECT_EQ(t.party().net().peer(t.person(3)).incarnation(), 0) << t.party().story();
}

}  // namespace
}  // namespace padr::test
