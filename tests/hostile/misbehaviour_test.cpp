// Who is cut off, for how long, and how many are remembered: the misbehaviour alone, beside a replica whose other
// member never says anything.
#include "common/membership/misbehaviour_policy.h"

#include <gtest/gtest.h>

#include "common/scenarios/scenarios.h"
#include "common/session/applied_commands.h"

namespace padr::node {
namespace {

using sync::DropReason;

class Guarded {
 public:
  explicit Guarded(bool sealed = true) : scene_(scenarios::load_embedded("ball", 1)), replica_(scene_, config()) {
    session_.config.sealed = sealed;
    session_.self = 0;
    session_.slots = 2;
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
    replica_.locate(1, at);
  }
  void run_to(Tick t) {
    while (replica_.replica().now() < t) replica_.step({});
  }
  void drop(DropReason why, std::size_t times = 1) {
    for (std::size_t i = 0; i < times; ++i)
      misbehaviour_.on_drop(1, why, view_of(replica_.replica()), tick_start(replica_.replica().now()), out_);
  }
  bool bars(std::uint8_t n) const { return misbehaviour_.bars(key(n), view_of(replica_.replica())); }
  bool hears() const { return misbehaviour_.hears(1, view_of(replica_.replica())); }
  std::uint32_t cut_offs() const { return replica_.replica().link(1).cut_offs; }
  std::size_t offenders() const { return misbehaviour_.offenders(); }

 private:
  static ReplicaConfig config() {
    ReplicaConfig c;
    c.self = 0;
    c.peers = c.slots = 2;
    return c;
  }
  Scene scene_;
  SessionState session_;
  RecordedReplica replica_;
  AppliedCommands out_{session_, replica_};
  MisbehaviourPolicy misbehaviour_{session_};
};

TEST(MisbehaviourPolicy, NonsenseIsBorneUntilThereIsTooMuchOfItInTooShortATime) {
  Guarded g;
  g.drop(DropReason::kValue, MisbehaviourPolicy::kNonsense - 1);
  EXPECT_FALSE(g.bars(1));
  g.run_to(MisbehaviourPolicy::kWithin);  // the first ones still count
  g.drop(DropReason::kMalformed);
  EXPECT_TRUE(g.bars(1));
  EXPECT_FALSE(g.hears());
  EXPECT_EQ(g.cut_offs(), 1U);

  Guarded later;
  later.drop(DropReason::kValue, MisbehaviourPolicy::kNonsense - 1);
  later.run_to(MisbehaviourPolicy::kWithin + 1);
  later.drop(DropReason::kMalformed);
  EXPECT_FALSE(later.bars(1));
  EXPECT_TRUE(later.hears());
}

// Nor what only this peer finds wrong, by its own clock or log: a liar can arrange that.
TEST(MisbehaviourPolicy, WhatTheNetworkDoesIsHeldAgainstNobody) {
  for (const DropReason why : {DropReason::kSeal, DropReason::kForeign, DropReason::kDuplicate, DropReason::kOrder,
                               DropReason::kCutOff, DropReason::kRight, DropReason::kTick}) {
    Guarded g;
    g.drop(why, 10 * MisbehaviourPolicy::kNonsense);
    EXPECT_FALSE(g.bars(1)) << sync::kDropNames[static_cast<std::size_t>(why)];
    EXPECT_TRUE(g.hears());
  }
}

// Only the member itself can have made the promise that it breaks. The ban ends: it cannot be shown to others.
TEST(MisbehaviourPolicy, WhoBreaksAPromiseIsBarredForAWhile) {
  Guarded g;
  g.drop(DropReason::kPromise);
  EXPECT_TRUE(g.bars(1));
  EXPECT_FALSE(g.hears());
  EXPECT_EQ(g.cut_offs(), 1U);
  g.run_to(MisbehaviourPolicy::kBarred + 1);
  EXPECT_FALSE(g.bars(1));

  Guarded anybody(false);
  anybody.drop(DropReason::kPromise);
  EXPECT_TRUE(anybody.hears()) << "without a key anybody can have promised that";
}

// Where nothing says who somebody is, nobody can be told from who speaks in his name.
TEST(MisbehaviourPolicy, WithoutAKeyNobodyIsCutOffForNonsense) {
  Guarded g(false);
  g.drop(DropReason::kValue, 10 * MisbehaviourPolicy::kNonsense);
  EXPECT_TRUE(g.hears());
  EXPECT_FALSE(g.bars(1));
  EXPECT_EQ(g.offenders(), 0U);
}

TEST(MisbehaviourPolicy, WhoSendsNonsenseStaysOut) {
  Guarded g;
  g.drop(DropReason::kValue, MisbehaviourPolicy::kNonsense);
  g.run_to(3 * MisbehaviourPolicy::kBarred);
  EXPECT_TRUE(g.bars(1));
  EXPECT_FALSE(g.bars(2)) << "who has said nothing";
}

// Once, whoever came first was forgotten first, barred or not: 64 programs that each said one wrong word brought a
// 65th back in.
TEST(MisbehaviourPolicy, OfManyOffendersThoseWhoAreBarredAreRememberedLongest) {
  Guarded g;
  g.drop(DropReason::kValue, MisbehaviourPolicy::kNonsense);
  for (std::uint8_t n = 2; n < 200; ++n) {
    g.is_now(n);
    g.drop(DropReason::kValue);
    EXPECT_LE(g.offenders(), MisbehaviourPolicy::kMostOffenders);
  }
  EXPECT_EQ(g.offenders(), MisbehaviourPolicy::kMostOffenders);
  EXPECT_TRUE(g.bars(1));
}

}  // namespace
}  // namespace padr::node
