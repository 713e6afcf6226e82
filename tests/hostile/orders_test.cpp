// A member that gives orders which are not its to give, or makes up what it passes on.
#include "tests/hostile/liar.h"

namespace padr::test {
namespace {

using sync::DropReason;

/// From now on the liar's next update is this, as often as it is said.
void give(Trial& t, std::function<void(sync::Bundle&)> order) {
  t.liar().begin(in_place_of_the_next(std::move(order)));
  t.party().net().attract(Vec2{10, 7});  // so that there is something to say
}

/// With a key peer 2, which lies, stays out for a while; without one nothing tells it from others, and it is let in
/// anew.
void expect_out(Trial& t, wire::SealMode mode) {
  const Endpoint at = ipv4({10, 0, 0, static_cast<std::uint8_t>(t.person(2) + 1)}, 7000);
  const auto is_in = [&] {
    const auto& seats = t.replica(0).roster().seats;
    return std::any_of(seats.begin(), seats.end(),
                       [&](const node::Seat& s) { return s.there() && same_place(s.at, at); });
  };
  EXPECT_TRUE(t.liar_was_out()) << t.party().story();
  if (mode == wire::SealMode::kAuth)
    EXPECT_FALSE(is_in()) << t.party().story();
  else
    EXPECT_TRUE(t.party().run_until(2, is_in)) << t.party().story();
  t.expect_no_harm();
}

// Who says so is heard no further, as what it has to say next cannot be known: it is declared gone itself.
TEST(Orders, RemovalByWhoIsNotCoordinator) {
  for (const auto mode : {wire::SealMode::kNone, wire::SealMode::kAuth}) {
    Trial t(4, 2, mode, 201);
    give(t, [&t](sync::Bundle& b) { b.removals = {{1, t.incarnation(1), 5}}; });
    t.party().run(16);
    EXPECT_GT(t.dropped(0, DropReason::kRight), 0U) << t.party().story();
    EXPECT_GT(t.dropped(1, DropReason::kRight), 0U) << t.party().story();
    expect_out(t, mode);
  }
}

TEST(Orders, RemovalOfTheCoordinator) {
  Trial t(4, 3, wire::SealMode::kAuth, 202);
  give(t, [&t](sync::Bundle& b) { b.removals = {{0, t.incarnation(0), 5}}; });
  t.party().run(16);
  EXPECT_GT(t.dropped(0, DropReason::kRight), 0U) << t.party().story();
  EXPECT_TRUE(t.liar_is_out()) << t.party().story();
  t.expect_no_harm();
}

// Not even the coordinator can declare somebody gone whom the others have not been asked about.
TEST(Orders, RemovalByTheCoordinatorThatAskedNobody) {
  Trial t(4, 0, wire::SealMode::kAuth, 203);
  give(t, [&t](sync::Bundle& b) { b.removals = {{2, t.incarnation(2), 5}}; });
  t.party().run(1);
  t.party().net().attract(Vec2{4, 4});  // the first update may have gone out before the lie
  t.party().run(18);
  EXPECT_GT(t.dropped(1, DropReason::kRight), 0U) << t.party().story();
  EXPECT_TRUE(t.liar_is_out()) << t.party().story();
  t.expect_no_harm();
}

// The liar orders a removal, and `lost` are killed 3 s apart; `seconds` after the last one the liar has to be out.
void expect_out_in_time(Trial& t, std::initializer_list<PeerId> lost, double seconds) {
  give(t, [&t](sync::Bundle& b) { b.removals = {{1, t.incarnation(1), 5}}; });
  EXPECT_TRUE(t.party().run_until(3, [&] { return t.dropped(0, DropReason::kRight) > 0; })) << t.party().story();
  for (const PeerId p : lost) {
    t.party().run(3);
    t.party().net().kill(t.person(p));
  }
  t.party().run(seconds);
  EXPECT_TRUE(t.liar_is_out()) << t.party().story();
  t.expect_no_harm();
}

// Once, another eviction meanwhile gave the liar 8 s more, and all joined anew before these were over.
TEST(Orders, WhoGivesOneIsCutOffInTimeThoughAnotherPeerIsLostMeanwhile) {
  Trial t(5, 3, wire::SealMode::kAuth, 209);
  expect_out_in_time(t, {4}, 14);
}

// Once, each further eviction gave the liar more time.
TEST(Orders, WhoGivesOneIsCutOffInTimeThoughOthersAreLostOneAfterTheOther) {
  Trial t(6, 3, wire::SealMode::kAuth, 210);
  expect_out_in_time(t, {4, 5}, 12);
}

TEST(Orders, NobodyIsDeclaredGoneToItselfByWhoIsNotCoordinator) {
  Trial t(4, 2, wire::SealMode::kAuth, 208);
  give(t, [&t](sync::Bundle& b) { b.removals = {{3, t.incarnation(3), 5}}; });
  t.party().run(18);
  EXPECT_GT(t.dropped(3, DropReason::kRight), 0U) << t.party().story();
  t.expect_no_harm();
}

TEST(Orders, AdmissionByWhoIsNotCoordinator) {
  Trial t(4, 2, wire::SealMode::kAuth, 204);
  give(t, [](sync::Bundle& b) {
    sync::Admission a;
    a.slot = 6;
    a.incarnation = 5000;
    a.at = ipv4({10, 0, 0, 66}, 7000);
    a.at.key[0] = 1;
    a.have.assign(12, 0);
    b.admission = a;
  });
  t.party().run(16);
  EXPECT_GT(t.dropped(0, DropReason::kRight), 0U) << t.party().story();
  for (const PeerId p : t.honest()) EXPECT_FALSE(t.replica(p).seat(6).there());
  EXPECT_TRUE(t.liar_is_out()) << t.party().story();
  t.expect_no_harm();
}

TEST(Orders, PassingOnByWhoIsNotCoordinator) {
  for (const auto mode : {wire::SealMode::kNone, wire::SealMode::kAuth}) {
    Trial t(4, 2, mode, 205);
    give(t, [](sync::Bundle& b) { b.passed_on = {avatar_update(1, 100'000, b.tick - 1)}; });
    t.party().run(16);
    EXPECT_GT(t.dropped(0, DropReason::kRight), 0U) << t.party().story();
    expect_out(t, mode);
  }
}

// The coordinator that does declare somebody gone may put words into its mouth, but for the signature.
TEST(Orders, TheCoordinatorInventsWhatALostPeerSaid) {
  Trial t(4, 0, wire::SealMode::kAuth, 206);
  std::uint64_t forged = 0;
  t.liar().begin([&](sync::StatePacket& p, PeerId) {
    for (sync::Bundle& b : p.updates) {
      if (b.removals.empty()) continue;
      sync::Bundle lie;
      lie.peer = b.peer;
      lie.index = b.index;
      lie.tick = b.tick;
      lie.passed_on = {avatar_update(b.removals[0].slot, b.removals[0].count, b.tick - 1)};
      lie.passed_on[0].signature = wire::sign_update(t.liar().key(), {t.session(), 0}, lie.passed_on[0]);
      b = lie;
      ++forged;
    }
  });
  t.party().net().kill(t.person(3));
  t.party().run(20);
  EXPECT_GT(forged, 0U);
  EXPECT_GT(t.dropped(1, DropReason::kRight) + t.dropped(2, DropReason::kRight), 0U) << t.party().story();
  t.expect_confirmed({1, 2});
}

/// The liar coordinates, and gives this order once.
void expect_refused(const sync::Admission& lie, std::uint64_t seed) {
  Trial t(4, 0, wire::SealMode::kAuth, seed);
  give(t, [&](sync::Bundle& b) {
    b.admission = lie;
    b.admission->have.assign(static_cast<std::size_t>(t.replica(1).config().slots), 0);
  });
  t.party().run(25);
  for (const PeerId p : t.honest()) {
    EXPECT_EQ(t.replica(p).seat(1).incarnation, p == 1 ? t.replica(p).seat(1).incarnation : t.incarnation(1));
    EXPECT_GT(t.dropped(p, DropReason::kRight), 0U) << t.party().story();
  }
  t.expect_no_harm();
  EXPECT_TRUE(t.liar_is_out()) << t.party().story();
  const int late = t.party().net().start(t.person(1));
  t.party().run(6);
  EXPECT_TRUE(t.party().net().peer(late).playing()) << t.party().story();
}

Endpoint nowhere() {
  Endpoint at = ipv4({192, 0, 2, 1}, 9);
  at.key.fill(7);
  return at;
}

// One admission with the highest incarnation, and no coordinator could count on.
TEST(Orders, AdmissionThatUsesUpTheNumbers) {
  expect_refused({9, (1U << 30U) - 1, 0, nowhere(), {}}, 211);
}

TEST(Orders, AdmissionToATakenSlot) {
  expect_refused({1, 5000, 0, nowhere(), {}}, 212);
}

// Once, all took whoever is at a newcomer's address for ended, though it has another key.
TEST(Orders, AdmissionAtTheAddressOfAnother) {
  Trial t(4, 0, wire::SealMode::kAuth, 213);
  Endpoint at = t.replica(1).seat(2).at;
  at.key.fill(7);
  t.liar().begin(in_place_of_the_next([&](sync::Bundle& b) {
    b.admission = sync::Admission{9, t.replica(1).roster().newest_incarnation() + 1, 0, at, {}};
    b.admission->have.assign(static_cast<std::size_t>(t.replica(1).config().slots), 0);
  }));
  t.party().net().attract(Vec2{10, 7});
  EXPECT_TRUE(t.party().run_until(10, [&] { return t.replica(1).seat(9).there() && t.replica(3).seat(9).there(); }))
      << t.party().story();
  t.party().net().kill(t.person(0));
  t.party().run(12);
  EXPECT_TRUE(t.replica(1).seat(2).there()) << t.party().story();
  EXPECT_TRUE(t.replica(3).seat(2).there()) << t.party().story();
  t.expect_no_harm();
}

// What passes for one's own word is known to have been said, or not.
TEST(Orders, NobodyPutsWordsIntoOnesOwnMouth) {
  Trial t(3, 0, wire::SealMode::kNone, 207);
  const std::uint32_t own = t.replica(1).agreed().log().have(1);
  give(t, [own](sync::Bundle& b) { b.passed_on = {avatar_update(1, own + 1000, b.tick - 1)}; });
  t.party().run(3);
  EXPECT_GT(t.dropped(1, DropReason::kRight), 0U) << t.party().story();
  t.party().run(14);
  t.expect_confirmed({1, 2});
}

}  // namespace
}  // namespace padr::test
