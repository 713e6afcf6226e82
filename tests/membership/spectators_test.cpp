// Members without an avatar: they watch, introduce and carry, and play needs none of them.
#include "tests/membership/party.h"
#include "tests/seed.h"

namespace padr::test {
namespace {

/// Persons in `spectators` have no avatar.
Party party_with(int wanted, std::set<int> spectators, int at_once, wire::SealMode seal = wire::SealMode::kNone) {
  lab::VirtualNetworkConfig c = party_config(wanted, "delay 40ms 10ms loss 2%", test::seed(120));
  c.seal = seal;
  c.spectates = [spectators = std::move(spectators)](int person) { return spectators.contains(person); };
  return Party(std::move(c), {}, at_once);
}

/// Slots with an avatar, in the confirmed world of a person.
int avatars(const Party& party, int person) {
  const auto& all = party.replica(person).agreed().confirmed().avatars;
  return static_cast<int>(std::count_if(all.begin(), all.end(), [](const auto& a) { return a.present; }));
}

/// The person has no avatar, holds and owns nothing, and has told nothing of avatars and bodies.
void expect_only_watches(const Party& party, int person) {
  const PeerId slot = party.replica(person).self();
  for (int p = 0; p < party.net().persons(); ++p) {
    if (!party.net().runs(p)) continue;
    const sync::FoldState& s = party.replica(p).agreed().confirmed();
    EXPECT_FALSE(s.avatars[slot].present);
    EXPECT_TRUE(s.members[slot].present);
    for (const sync::Authority& a : s.authority) EXPECT_NE(a.owner, slot);
    for (const PeerSet held : s.holds) EXPECT_EQ(held & only(slot), 0U);
  }
  for (const std::uint64_t n : party.replica(person).stats().updates_by_cause) EXPECT_EQ(n, 0U);
}

TEST(Spectators, PlayWaitsForPlayersOnly) {
  Party party = party_with(2, {0, 2}, 3);
  party.run(6);
  EXPECT_TRUE(party.united()) << party.story();
  for (int p = 0; p < 3; ++p) EXPECT_EQ(party.replica(p).start().wanted, 2);
  EXPECT_EQ(avatars(party, 1), 1);
  party.net().start(0);
  const auto took = party.run_until(6, [&] { return party.started(); });
  ASSERT_TRUE(took) << party.story();
  party.expect_to_stay(4);
  expect_only_watches(party, 0);
  expect_only_watches(party, 2);
  EXPECT_EQ(avatars(party, 3), 2);
  EXPECT_EQ(party.net().peer(0).session().players(), 2);
  EXPECT_EQ(party.net().peer(3).session().spectators(), 2);
}

// Once, a founder that only watches counted as the one player: play began at once, without anybody.
TEST(Spectators, PlayWaitsForTheOnlyPlayer) {
  Party party = party_with(1, {0}, 1);
  party.run(3);
  EXPECT_EQ(party.replica(0).start().wanted, 1);
  party.net().start(0);
  ASSERT_TRUE(party.run_until(6, [&] { return party.started(); })) << party.story();
  EXPECT_EQ(avatars(party, 1), 1);
}

TEST(Spectators, SeeWhatPlayersSee) {
  Party party = party_with(3, {3}, 3, wire::SealMode::kEncrypt);
  party.run(5);
  party.net().start(1);
  party.run(10);
  EXPECT_TRUE(party.united()) << party.story();
  expect_only_watches(party, 3);
  // The judge compares their confirmed worlds at each tick.
  EXPECT_LT(party.lag(3), 60);
  for (const EntityId b : {EntityId{0}, EntityId{5}})
    EXPECT_LT(distance(party.replica(3).live().world().position(b), party.replica(0).live().world().position(b)), 1);
  party.expect_to_stay(4);
}

// Nothing that play needs is lost with one, be it the founder.
TEST(Spectators, PlayGoesOnWithoutThem) {
  for (const bool killed : {false, true}) {
    Party party = party_with(2, {0}, 3);
    party.run(6);
    ASSERT_TRUE(party.united()) << party.story();
    killed ? party.net().kill(0) : party.net().leave(0);
    party.run(8);
    EXPECT_TRUE(party.united()) << party.story();
    EXPECT_EQ(party.net().peer(1).session().spectators(), 0);
    party.expect_to_stay(0);
    party.net().start(1);
    party.run(5);
    EXPECT_TRUE(party.united()) << party.story();
    EXPECT_EQ(avatars(party, 1), 3);
  }
}

// A meeting point outlives its players: those who come later find the world as it was left.
TEST(Spectators, KeepTheWorldUntilPlayersComeAgain) {
  Party party = party_with(2, {0}, 3);
  party.run(8);
  for (const int p : {1, 2}) party.net().leave(p);
  party.run(6);
  EXPECT_FALSE(party.net().runs(1));
  EXPECT_EQ(avatars(party, 0), 0);
  const Tick before = party.replica(0).agreed().confirmed().tick;
  for (int n = 0; n < 2; ++n) party.net().start(0);
  party.run(6);
  EXPECT_TRUE(party.united()) << party.story();
  EXPECT_TRUE(party.started());
  EXPECT_GT(party.replica(3).agreed().confirmed().tick, before);
  EXPECT_EQ(party.judge().violation(), "");
}

// One that joins anew, as its machine stood still, is a spectator again.
TEST(Spectators, StaySpectators) {
  Party party = party_with(2, {2}, 3);
  party.run(6);
  party.net().pause(2, true);
  party.run(12);
  party.net().pause(2, false);
  party.run(8);
  EXPECT_TRUE(party.united()) << party.story();
  EXPECT_EQ(party.net().peer(2).incarnation(), 1);
  expect_only_watches(party, 2);
  EXPECT_EQ(party.judge().violation(), "");
}

// It may say what it likes: a member without an avatar touches nothing.
TEST(Spectators, CannotTouchTheWorld) {
  const Scene scene = party_config(2, "", 1).scene;
  sync::Fold fold(scene, 4, 2, true);
  sync::Bundle b;
  b.peer = 1;
  b.spectates = true;
  fold.apply(b);
  b.spectates = false;
  b.avatar = sync::AvatarUpdate{};
  sync::BodyUpdate u;
  u.body = 3;
  u.held = u.has_state = true;
  u.epoch = 1;
  u.state.position = {1, 1};
  b.bodies.push_back(u);
  sync::FoldState before;
  fold.save(before);
  fold.apply(b);
  EXPECT_TRUE(fold.members()[1].present);
  EXPECT_FALSE(fold.avatars()[1].present);
  EXPECT_EQ(fold.authority()[3].owner, kNoPeer);
  EXPECT_FALSE(fold.holds(1, 3));
  EXPECT_EQ(fold.world().state(3).position, before.world.entities[3].position);
}

// What it owned goes on by physics, as that of one who leaves.
TEST(Spectators, LetGoOfWhatTheyHad) {
  const Scene scene = party_config(2, "", 1).scene;
  sync::Fold fold(scene, 4, 2, true);
  sync::Bundle b;
  b.peer = 1;
  sync::BodyUpdate u;
  u.body = 3;
  u.held = u.has_state = true;
  u.epoch = 1;
  u.state = fold.world().state(3);
  b.bodies.push_back(u);
  fold.apply(b);
  ASSERT_EQ(fold.authority()[3].holder(), 1);
  sync::Bundle away;
  away.peer = 1;
  away.spectates = true;
  fold.apply(away);
  EXPECT_EQ(fold.authority()[3].holder(), kNoPeer);
  EXPECT_FALSE(fold.holds(1, 3));
  EXPECT_FALSE(fold.world().present(fold.world().avatar(1)));
}

}  // namespace
}  // namespace padr::test
