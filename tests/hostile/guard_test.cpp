// Who is cut off, for how long, and how many are remembered: the guard alone, beside a node whose other member never
// says anything.
#include "common/node/guard.h"

#include <gtest/gtest.h>

#include "common/node/removals.h"
#include "common/scenarios/scenarios.h"

namespace padr::node {
namespace {

using sync::DropReason;

class Guarded {
 public:
  explicit Guarded(bool sealed = true) : scene_(scenarios::load_embedded("ball", 1)), node_(scene_, config()) {
    desk_.config.sealed = sealed;
    desk_.self = 0;
    desk_.slots = 2;
    is_now(1);
  }
  static PublicKey key(std::uint8_t n) {
    PublicKey k{};
    k.fill(n);
    return k;
  }
  /// Whoever sits in the other slot has this key from now on.
  void is_now(std::uint8_t n) {
    Endpoint at;
    at.port = 9000;
    at.key = key(n);
    node_.locate(1, at);
  }
  void run_to(Tick t) {
    while (node_.node().now() < t) node_.step({});
  }
  void drop(DropReason why, std::size_t times = 1) {
    for (std::size_t i = 0; i < times; ++i) guard_.on_drop(1, why, node_, removals_, tick_start(node_.node().now()));
  }
  bool bars(std::uint8_t n) const { return guard_.bars(key(n), node_.node()); }
  bool hears() const { return guard_.hears(1, node_.node()); }
  std::uint32_t cut_offs() const { return node_.node().other(1).cut_offs; }
  std::size_t offenders() const { return guard_.offenders(); }

 private:
  static NodeConfig config() {
    NodeConfig c;
    c.self = 0;
    c.peers = c.slots = 2;
    return c;
  }
  Scene scene_;
  SessionDesk desk_;
  RecordedNode node_;
  Removals removals_{desk_};
  Guard guard_{desk_};
};

TEST(Guard, NonsenseIsBorneUntilThereIsTooMuchOfItInTooShortATime) {
  Guarded g;
  g.drop(DropReason::kValue, Guard::kNonsense - 1);
  EXPECT_FALSE(g.bars(1));
  g.run_to(Guard::kWithin);  // the first ones still count
  g.drop(DropReason::kMalformed);
  EXPECT_TRUE(g.bars(1));
  EXPECT_FALSE(g.hears());
  EXPECT_EQ(g.cut_offs(), 1U);

  Guarded later;
  later.drop(DropReason::kValue, Guard::kNonsense - 1);
  later.run_to(Guard::kWithin + 1);
  later.drop(DropReason::kMalformed);
  EXPECT_FALSE(later.bars(1));
  EXPECT_TRUE(later.hears());
}

TEST(Guard, WhatTheNetworkDoesIsHeldAgainstNobody) {
  for (const DropReason why : {DropReason::kSeal, DropReason::kForeign, DropReason::kDuplicate, DropReason::kOrder,
                               DropReason::kCutOff, DropReason::kRight}) {
    Guarded g;
    g.drop(why, 10 * Guard::kNonsense);
    EXPECT_FALSE(g.bars(1)) << sync::kDropNames[static_cast<std::size_t>(why)];
    EXPECT_TRUE(g.hears());
  }
}

TEST(Guard, AnOrderOfNoRightMayBeTriedForAWhile) {
  Guarded g;
  for (Tick t = 1; t < Guard::kInsists; t += 30) {
    g.run_to(t);
    g.drop(DropReason::kRight);
  }
  EXPECT_TRUE(g.hears());
  g.run_to(1 + Guard::kInsists);
  g.drop(DropReason::kRight);
  EXPECT_FALSE(g.hears());
  // With a break in between it begins anew.
  Guarded again;
  again.drop(DropReason::kRight);
  again.run_to(Guard::kMuted + 1);
  again.drop(DropReason::kRight);
  again.run_to(Guard::kInsists + 1);
  again.drop(DropReason::kRight);
  EXPECT_TRUE(again.hears());
}

TEST(Guard, ASeriesOfSuchOrdersBeginsWithItsFirst) {
  Guarded g;
  constexpr Tick kFirst = 100;  // less than kMuted after the beginning
  for (Tick t = kFirst; t < kFirst + Guard::kInsists; t += 30) {
    g.run_to(t);
    g.drop(DropReason::kRight);
    EXPECT_TRUE(g.hears()) << "tick " << t;
  }
  g.run_to(kFirst + Guard::kInsists);
  g.drop(DropReason::kRight);
  EXPECT_FALSE(g.hears());
}

// Where nothing says who somebody is, nobody can be told from who speaks in his name.
TEST(Guard, WithoutAKeyNobodyIsCutOffForNonsense) {
  Guarded g(false);
  g.drop(DropReason::kValue, 10 * Guard::kNonsense);
  EXPECT_TRUE(g.hears());
  EXPECT_FALSE(g.bars(1));
  EXPECT_EQ(g.offenders(), 0U);
}

// The other one says nothing: it is in arrears, and that may have been its network.
TEST(Guard, WhoWasInArrearsMayComeBackAfterAMinuteAndThenTwo) {
  Guarded g;
  g.run_to(Guard::kArrears);
  Tick now = Guard::kArrears;
  for (const Tick barred : {Guard::kBarred, 2 * Guard::kBarred}) {
    g.drop(DropReason::kValue, Guard::kNonsense);
    g.run_to(now + barred - 1);
    EXPECT_TRUE(g.bars(1)) << barred;
    g.run_to(now + barred);
    EXPECT_FALSE(g.bars(1)) << barred;
    now += barred;
  }
}

TEST(Guard, WhoWasNotStaysOut) {
  Guarded g;
  g.drop(DropReason::kValue, Guard::kNonsense);
  g.run_to(3 * Guard::kBarred);
  EXPECT_TRUE(g.bars(1));
  EXPECT_FALSE(g.bars(2)) << "who has said nothing";
}

// Once, whoever came first was forgotten first, barred or not: 64 programs that each said one wrong word brought a
// 65th back in.
TEST(Guard, OfManyOffendersThoseWhoAreBarredAreRememberedLongest) {
  Guarded g;
  g.drop(DropReason::kValue, Guard::kNonsense);
  for (std::uint8_t n = 2; n < 200; ++n) {
    g.is_now(n);
    g.drop(DropReason::kValue);
    EXPECT_LE(g.offenders(), Guard::kMostOffenders);
  }
  EXPECT_EQ(g.offenders(), Guard::kMostOffenders);
  EXPECT_TRUE(g.bars(1));
}

}  // namespace
}  // namespace padr::node
