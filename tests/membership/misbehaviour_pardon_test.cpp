// For how long whoever was cut off is barred, and what it takes to be heard again.
#include "common/membership/misbehaviour_policy.h"

#include "tests/membership/rules.h"

namespace padr::test {
namespace {

using node::MisbehaviourPolicy;

// Once, it was cut off with the first datagram after a silence of two seconds, before any update could come.
TEST(MisbehaviourRules, WhoIsHeardAgainHasAMomentToTellWhatItOwes) {
  for (const bool long_owed : {false, true}) {
    Situation s(4, 0);
    const Tick owed = MisbehaviourPolicy::kMostArrears - (long_owed ? 0 : MisbehaviourPolicy::kBackFor);
    s.log.begin(2, 0, s.roster.now - owed);
    s.silence(2, s.roster.now - 2 * kTicksPerSecond);
    MisbehaviourPolicy rules(s.session);
    ListedCommands out;
    const auto pass = [&](Tick ticks) {
      for (Tick t = 0; t < ticks; ++t, ++s.roster.now) {
        rules.advance(s.view(), out);
        s.silence(2, s.roster.now + 1);
      }
    };
    pass(1);
    EXPECT_TRUE(out.cut_offs.empty());
    pass(MisbehaviourPolicy::kBackFor - 1);
    EXPECT_EQ(out.cut_offs.empty(), !long_owed);
    pass(1);
    EXPECT_FALSE(out.cut_offs.empty());
  }
}

TEST(MisbehaviourRules, WhoIsConvictedIsGivenUpByWhoeverHadBarredItBefore) {
  Situation s(4, 0);
  s.session.config.sealed = true;
  s.roster.seats[2].at.key.fill(9);
  MisbehaviourPolicy before(s.session);
  ListedCommands out;
  before.convict(2, s.view(), out);
  EXPECT_EQ(out.cut_offs, std::vector<PeerId>{2});
  EXPECT_EQ(out.given_up, std::vector<PeerId>{2});
  MisbehaviourPolicy rules(s.session);
  rules.inherit(before, {});
  rules.convict(2, s.view(), out);
  EXPECT_EQ(out.cut_offs.size(), 1U) << "it is not told twice";
  EXPECT_EQ(out.given_up.size(), 2U);
  s.roster.give_up(2, true);
  rules.convict(2, s.view(), out);
  EXPECT_EQ(out.given_up.size(), 2U);
}

// Once, a peer that came back by a coordinator that it ignored heard nothing of what the others followed.
TEST(MisbehaviourRules, WhoHasLetThisPeerInAnewIsHeardUnlessItIsBarredForGood) {
  Situation s(4, 0);
  s.session.config.sealed = true;
  for (PeerId p = 1; p < 4; ++p) s.roster.seats[p].at.key.fill(p);
  MisbehaviourPolicy before(s.session);
  ListedCommands out;
  before.distrust(1, s.view(), out);
  before.distrust(2, s.view(), out);
  before.convict(3, s.view(), out);
  for (const PeerId by : {PeerId{1}, PeerId{3}}) {
    MisbehaviourPolicy rules(s.session);
    rules.inherit(before, s.roster.seats[by].at.key);
    EXPECT_EQ(rules.hears(1, s.view()), by == 1);
    EXPECT_FALSE(rules.hears(2, s.view()));
    EXPECT_FALSE(rules.hears(3, s.view()));
  }
}

// It may have cut off this peer itself. All is acknowledged once it is in anew.
TEST(MisbehaviourRules, WhoHasAcknowledgedNothingMayComeInAnewOnce) {
  Situation s(4, 0);
  s.session.config.sealed = true;
  for (PeerId p = 1; p < 4; ++p) s.roster.seats[p].at.key.fill(p);
  MisbehaviourPolicy rules(s.session);
  const auto ignores = [&](PeerId p) {
    ListedCommands out;
    s.roster.seats[p].unacknowledged = s.roster.now - MisbehaviourPolicy::kPatience;
    rules.advance(s.view(), out);
    s.roster.seats[p].unacknowledged = -1;
  };
  const auto may_join = [&](PeerId p) {
    rules.pardon(s.roster.seats[p].at.key);
    return !rules.bars(s.roster.seats[p].at.key, s.view());
  };
  ignores(2);
  EXPECT_TRUE(may_join(2));
  EXPECT_FALSE(rules.hears(2, s.view())) << "in its present incarnation it is not heard";
  ++s.roster.seats[2].incarnation;
  EXPECT_TRUE(rules.hears(2, s.view()));
  ignores(2);
  EXPECT_FALSE(may_join(2)) << "once";
  ListedCommands out;
  rules.distrust(1, s.view(), out);
  EXPECT_FALSE(may_join(1));
  ignores(3);
  rules.convict(3, s.view(), out);
  EXPECT_FALSE(may_join(3));
}

// It may have been its network. Once, a player whose uplink had been full for some seconds was kept out for a minute.
TEST(MisbehaviourRules, WhoHeldUpEverybodyIsHeardAgainAfterTenSecondsThenAMinuteAndThenTwo) {
  Situation s(4, 0);
  s.session.config.sealed = true;
  s.roster.seats[2].at.key.fill(9);
  MisbehaviourPolicy rules(s.session);
  for (const Tick barred :
       {MisbehaviourPolicy::kBarredAtFirst, MisbehaviourPolicy::kBarred, 2 * MisbehaviourPolicy::kBarred}) {
    s.roster.seats[2].heard = s.roster.now;
    s.roster.seats[2].unacknowledged = s.roster.now - MisbehaviourPolicy::kPatience;
    ListedCommands out;
    rules.advance(s.view(), out);
    EXPECT_EQ(out.cut_offs, std::vector<PeerId>{2});
    s.roster.seats[2].unacknowledged = -1;
    s.roster.now += barred - 1;
    EXPECT_EQ(rules.bars_for(s.roster.seats[2].at.key, s.view()), 1) << barred;
    EXPECT_FALSE(rules.hears(2, s.view())) << barred;
    ++s.roster.now;
    EXPECT_FALSE(rules.bars(s.roster.seats[2].at.key, s.view())) << barred;
    EXPECT_TRUE(rules.hears(2, s.view())) << barred;
  }
}

}  // namespace
}  // namespace padr::test
