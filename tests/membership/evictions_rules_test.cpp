// What the coordinator asks and orders about a peer that is lost: what is seen and what is to be done.
#include "common/membership/evictions.h"

#include "common/membership/misbehaviour_policy.h"
#include "tests/membership/rules.h"

namespace padr::test {
namespace {

using node::Evictions;
using node::SessionEvent;

/// Slot 0 coordinates four; slot 3 has told two updates, of which it has the first, and falls silent.
class Eviction : public testing::Test {
 protected:
  Eviction() {
    s_.tells(3, 0, kNow - 300);
    s_.silence(3, kNow - node::kDoubt);
  }
  void tick(ListedCommands& out) {
    rules_.advance(s_.view(), out);
    s_.follow(out);
  }
  void pass(Tick ticks) {
    for (Tick t = 0; t < ticks; ++t) {
      for (const PeerId p : {PeerId{1}, PeerId{2}})
        s_.roster.seats[p].heard = s_.roster.seats[p].answered = s_.roster.now;
      ListedCommands out;
      tick(out);
      orders_.insert(orders_.end(), out.orders.begin(), out.orders.end());
    }
  }
  void reply(PeerId from, bool frozen, std::uint32_t have, Tick heard_ago) {
    wire::Answer a{{s_.named(3)}, frozen, s_.roster.now, number_};
    a.lost[0].have = have;
    a.lost[0].heard = heard_ago < 0 ? 0 : static_cast<std::uint32_t>(1 + heard_ago);
    ListedCommands out;
    rules_.on_answer(from, a, s_.view(), out);
    heard_again_ |= out.told(SessionEvent::Kind::kHeardAgain);
  }

  /// A member sends an update of the lost peer. How many count as proof that it lives.
  std::size_t send(PeerId by, std::uint32_t index, Tick tick, int passings = 0) {
    sync::Bundle b;
    for (int i = passings; i >= 0; --i) {
      sync::Bundle outer;
      outer.peer = i % 2 == 0 ? PeerId{3} : PeerId{2};
      outer.index = index;
      outer.tick = tick;
      if (i < passings) outer.passed_on.push_back(b);
      b = outer;
    }
    ListedCommands out;
    node::MisbehaviourPolicy misbehaviour(s_.session);
    rules_.on_fetched(by, {3, 4, {b}}, s_.view(), misbehaviour, out);
    s_.follow(out);
    return out.relayed.size();
  }

  /// Nobody hears it any more: its eviction begins.
  void begin() {
    pass(1);
    reply(1, false, 1, -1);
    reply(2, false, 1, -1);
    pass(node::kSilence - node::kDoubt);
    ASSERT_TRUE(rules_.busy());
  }

  Situation s_{4, 0};
  Evictions rules_{s_.session};
  std::vector<sync::Bundle> orders_;
  std::uint32_t number_ = 0;
  bool heard_again_ = false;
};

TEST_F(Eviction, BeginsWithTheQuestionWhoHearsIt) {
  ListedCommands out;
  tick(out);
  const auto polls = out.all<wire::Poll>();
  ASSERT_EQ(polls.size(), 3U) << "it is asked itself, too";
  EXPECT_FALSE(polls[0].message.freeze);
  EXPECT_EQ(polls[0].message.lost[0].slot, 3);
  EXPECT_TRUE(out.freezes.empty());
}

TEST_F(Eviction, WaitsForNobodyWhoHearsIt) {
  pass(1);
  reply(1, false, 1, 5);
  reply(2, false, 1, -1);
  pass(node::kSilence - node::kDoubt);
  EXPECT_FALSE(rules_.busy()) << "peer 1 has just heard it";
}

TEST_F(Eviction, OrdersWhatNobodyMayLackAndThenTheRemoval) {
  begin();
  EXPECT_TRUE(s_.roster.seats[3].frozen);
  reply(1, true, 1, -1);
  pass(3);
  EXPECT_TRUE(orders_.empty()) << "peer 2 has not replied";
  reply(2, true, 2, -1);
  pass(Evictions::kAskAgain + 1);
  EXPECT_TRUE(orders_.empty()) << "peer 2 has an update that is missing here";
  send(1, 1, kNow - 200);
  pass(1);
  ASSERT_EQ(orders_.size(), 2U);
  ASSERT_EQ(orders_[0].passed_on.size(), 1U);
  EXPECT_EQ(orders_[0].passed_on[0].index, 1U) << "peer 1 lacks it, and so did this one";
  ASSERT_EQ(orders_[1].removals.size(), 1U);
  EXPECT_EQ(orders_[1].removals[0], (sync::Removal{3, 4, 2}));
}

// No log takes two updates of one tick: what all are told to file, all could only wait for. So its log ends before.
// Its clock was ahead. Once, the next occupant of its slot was moved by these, except for that one itself.
TEST_F(Eviction, IsOrderedAfterTheLastUpdateThatAllHave) {
  begin();
  const Tick ahead = s_.roster.now + 30;
  s_.tells(3, 1, ahead);
  reply(1, true, 2, -1);
  reply(2, true, 2, -1);
  while (s_.roster.now <= ahead) {
    pass(1);
    ASSERT_TRUE(orders_.empty()) << s_.roster.now;
  }
  pass(1);
  ASSERT_EQ(orders_.size(), 1U);
  EXPECT_EQ(orders_[0].removals[0], (sync::Removal{3, 4, 2}));
}

TEST_F(Eviction, PassesOnNoUpdateThatIsNoLaterThanTheOneBefore) {
  begin();
  reply(1, true, 1, -1);
  reply(2, true, 4, -1);
  pass(1);
  send(2, 1, kNow - 200);
  send(2, 2, kNow - 200);
  send(2, 3, kNow - 100);
  pass(1);
  ASSERT_EQ(orders_.size(), 2U);
  ASSERT_EQ(orders_[0].passed_on.size(), 1U);
  EXPECT_EQ(orders_[0].passed_on[0].index, 1U);
  EXPECT_EQ(orders_[1].removals, (std::vector<sync::Removal>{{3, 4, 2}}));
}

TEST_F(Eviction, PassesOnNoUpdateThatIsNoLaterThanTheLastThatAllHave) {
  begin();
  reply(1, true, 1, -1);
  reply(2, true, 2, -1);
  pass(1);
  send(2, 1, kNow - 300);
  pass(1);
  ASSERT_EQ(orders_.size(), 1U);
  EXPECT_EQ(orders_[0].removals, (std::vector<sync::Removal>{{3, 4, 1}}));
}

// Once, a coordinator that passed it on sent datagrams that nobody can decode, and was cut off by all for good.
TEST_F(Eviction, PassesOnNoUpdateThatAnotherOneCouldNotHold) {
  begin();
  reply(1, true, 1, -1);
  reply(2, true, 3, -1);
  pass(1);
  send(2, 1, kNow - 200, sync::kMaxPassing - 1);
  send(2, 2, kNow - 100, sync::kMaxPassing);
  pass(1);
  ASSERT_EQ(orders_.size(), 2U);
  EXPECT_EQ(orders_[0].passed_on[0].index, 1U);
  EXPECT_EQ(orders_[1].removals, (std::vector<sync::Removal>{{3, 4, 2}}));
}

// Once, the eviction waited for that tick.
TEST_F(Eviction, TakesNoUpdateFromTheFuture) {
  begin();
  reply(1, true, 1, -1);
  reply(2, true, 2, -1);
  pass(1);
  send(1, 1, kNow + 1000);
  pass(1);
  EXPECT_TRUE(orders_.empty());
  send(2, 1, kNow - 100);
  pass(1);
  ASSERT_EQ(orders_.size(), 2U);
  EXPECT_EQ(orders_[0].passed_on[0].tick, kNow - 100);
}

TEST_F(Eviction, IsTakenBackIfAMemberHearsItAgain) {
  begin();
  reply(1, false, 1, 2);
  EXPECT_TRUE(heard_again_);
  EXPECT_FALSE(rules_.busy());
  ListedCommands out;
  tick(out);
  const auto polls = out.all<wire::Poll>();
  ASSERT_FALSE(polls.empty());
  EXPECT_EQ(polls[0].message.number, 1U);
  EXPECT_FALSE(s_.roster.seats[3].frozen);
}

// In a day somebody may fall silent for a moment so often. Once, nothing could be taken back after the last number.
TEST_F(Eviction, IsTakenBackHoweverOftenThatWasSoBefore) {
  for (std::uint32_t n = 0; n < wire::kMostPollNumber + 3; ++n) {
    s_.log.mark(3, s_.roster.now, 1);
    s_.silence(3, s_.roster.now - node::kDoubt);
    number_ = rules_.number();
    begin();
    heard_again_ = false;
    reply(1, false, 1, 2);
    ASSERT_TRUE(heard_again_) << n;
    ASSERT_FALSE(rules_.busy()) << n;
    ASSERT_NE(rules_.number(), number_);
    ASSERT_LE(rules_.number(), wire::kMostPollNumber);
    pass(1);
    ASSERT_FALSE(s_.roster.seats[3].frozen) << n;
  }
}

// Once, only members could say so; but the lost peer was the one through which they would have got the polls.
TEST_F(Eviction, IsTakenBackIfTheCoordinatorItselfHearsItAgain) {
  begin();
  for (Tick t = 0; t <= Evictions::kHeardAgain; ++t) {
    EXPECT_TRUE(rules_.busy());
    s_.roster.note_answer_of_frozen(3);
    pass(1);
  }
  EXPECT_FALSE(rules_.busy());
  EXPECT_FALSE(s_.roster.seats[3].frozen);
  EXPECT_EQ(rules_.number(), 1U);
  EXPECT_TRUE(orders_.empty());
}

// This peer has frozen it for an asker that is lost itself. Once, it was polled about again and again, and with each
// time that its poll was taken back the eviction of the asker began anew.
TEST_F(Eviction, OfWhomAnotherAskerHadFrozenIsNotBegunWhileThisPeerHearsIt) {
  s_.roster.freeze(3, true);
  for (Tick t = 0; t < 3 * node::kSilence; ++t) {
    s_.roster.note_answer_of_frozen(3);
    s_.roster.seats[3].frozen = true;  // as long as the asker is there
    pass(1);
  }
  EXPECT_FALSE(rules_.busy());
  EXPECT_EQ(rules_.number(), 0U);
  for (Tick t = 0; t <= node::Roster::kAnswerPause + node::kAnswerPatience; ++t) {
    s_.roster.seats[3].frozen = true;
    pass(1);
  }
  EXPECT_TRUE(rules_.busy()) << "it has fallen silent for this peer, too";
  EXPECT_EQ(rules_.number(), 0U);
}

// Nobody else can tell whether it does, so it is not evicted.
TEST_F(Eviction, GoesOnWithoutAMemberThatWithholdsItsReply) {
  begin();
  reply(1, true, 0, -1);
  pass(Evictions::kWithheld - 1);
  s_.roster.seats[2].excused = s_.roster.now;
  pass(Evictions::kWithheld - 1);
  EXPECT_TRUE(orders_.empty()) << "who was held up could not hear the replies";
  pass(2);
  ASSERT_FALSE(orders_.empty());
  EXPECT_EQ(orders_.back().removals, (std::vector<sync::Removal>{{3, 4, 1}}));
  EXPECT_FALSE(s_.roster.seats[2].frozen);
}

// It ignores this peer, and all waited for its reply before anybody was let in.
TEST_F(Eviction, GoesOnSoonerWithoutAMemberThatHasAskedToBeLetInAnew) {
  begin();
  s_.returning = only(1) | only(2);
  reply(1, true, 0, -1);
  pass(Evictions::kReturning - 2);
  EXPECT_TRUE(orders_.empty());
  EXPECT_TRUE(rules_.busy());
  pass(3);
  EXPECT_EQ(orders_.size(), 2U) << "the other one has replied, and gets what it lacks";
}

// They follow another one, and would not take its order. Once, it went on without all of them, and they cut it off for
// the update that they refused.
TEST_F(Eviction, IsNotOrderedIfNoneOfSeveralMembersFollows) {
  begin();
  pass(Evictions::kWithheld / 2);
  s_.roster.seats[2].excused = s_.roster.now;
  pass(Evictions::kWithheld / 2);
  EXPECT_FALSE(rules_.is_forsaken());
  pass(Evictions::kWithheld);
  EXPECT_TRUE(rules_.is_forsaken()) << "the one has been silent for longer than the other";
  EXPECT_TRUE(orders_.empty());
  reply(2, true, 1, -1);
  pass(1);
  EXPECT_FALSE(rules_.is_forsaken()) << "one follows after all";
}

TEST_F(Eviction, IsOrderedIfTheOnlyMemberLeftDoesNotFollow) {
  begin();
  s_.roster.seats[2].presence = node::Presence::kLeft;
  pass(Evictions::kWithheld + 1);
  EXPECT_FALSE(rules_.is_forsaken()) << "it may be lying";
  EXPECT_EQ(orders_.size(), 1U);
}

// Once, the updates of a busy peer took longer than others wait for something to be confirmed.
TEST_F(Eviction, AsksForManyUpdatesAtOnce) {
  begin();
  reply(1, true, 60, -1);
  reply(2, true, 1, -1);
  ListedCommands out;
  rules_.advance(s_.view(), out);
  const auto fetches = out.all<wire::Fetch>();
  ASSERT_EQ(fetches.size(), 4U);
  for (std::size_t i = 0; i < fetches.size(); ++i) {
    EXPECT_EQ(fetches[i].to, s_.roster.seats[1].at);
    EXPECT_EQ(fetches[i].message.from, 1 + 6 * i);
  }
}

// It need not agree with anybody any more. Once, one that only said that it left held up every eviction for 7.5 s, and
// with them all admissions.
TEST_F(Eviction, DoesNotWaitForAMemberThatHasLeft) {
  begin();
  s_.roster.seats[2].presence = node::Presence::kLeft;
  reply(1, true, 1, -1);
  pass(1);
  ASSERT_EQ(orders_.size(), 1U);
  EXPECT_EQ(orders_[0].removals, (std::vector<sync::Removal>{{3, 4, 1}}));
}

// It claims to lack what is no longer here, as all have confirmed it. Once, those were left out who could not show it.
TEST_F(Eviction, GoesOnWithoutAMemberThatSaysItLacksWhatAllHaveConfirmed) {
  s_.log.prune(kNow - 100, kNow - 100);
  begin();
  reply(1, true, 1, -1);
  reply(2, true, 0, -1);
  pass(Evictions::kUnsent - 1);
  EXPECT_TRUE(orders_.empty());
  pass(2);
  ASSERT_FALSE(orders_.empty());
  EXPECT_EQ(orders_.back().removals, (std::vector<sync::Removal>{{3, 4, 1}}));
}

// The states that the others began with have it. Once, the coordinator went on without, and the others had confirmed
// another world.
TEST_F(Eviction, IsNotOrderedIfAllOthersHaveAnUpdateThatNobodyCanSend) {
  begin();
  send(1, 2, kNow - 200);
  reply(1, true, 3, -1);
  reply(2, true, 3, -1);
  pass(Evictions::kUnsent - 1);
  EXPECT_FALSE(rules_.is_behind());
  pass(2);
  EXPECT_TRUE(rules_.is_behind());
  EXPECT_TRUE(orders_.empty());
  send(1, 1, kNow - 300);
  pass(1);
  EXPECT_FALSE(rules_.is_behind()) << "it has come after all";
  EXPECT_FALSE(orders_.empty());
}

TEST_F(Eviction, IsOrderedIfOnlySomeSayThatTheyHaveAnUpdateThatNobodyCanSend) {
  begin();
  send(1, 2, kNow - 200);
  reply(1, true, 3, -1);
  reply(2, true, 1, -1);
  pass(Evictions::kUnsent + 1);
  EXPECT_FALSE(rules_.is_behind());
  EXPECT_FALSE(orders_.empty());
}

TEST_F(Eviction, IsOrderedIfNothingShowsThatThereIsAnUpdateThatAllOthersSayTheyHave) {
  begin();
  reply(1, true, 3, -1);
  reply(2, true, 3, -1);
  pass(Evictions::kUnsent + 1);
  EXPECT_FALSE(rules_.is_behind());
  EXPECT_FALSE(orders_.empty());
}

// Once, this ended the coordinator's process.
TEST_F(Eviction, AsksWhoComesWhileAnUpdateIsMissing) {
  s_.roster.seats[2].presence = node::Presence::kAbsent;
  begin();
  reply(1, true, 3, -1);
  pass(2);
  s_.roster.seats[2].presence = node::Presence::kThere;
  pass(2);
  EXPECT_TRUE(orders_.empty());
  EXPECT_TRUE(rules_.busy());
  reply(2, true, 1, -1);
  pass(Evictions::kUnsent + 1);
  EXPECT_FALSE(orders_.empty());
}

TEST_F(Eviction, IsTakenBackIfTheLostPeerHasPublishedSomethingNew) {
  begin();
  EXPECT_EQ(send(1, 1, s_.roster.now - node::kSilence), 0U) << "before it fell silent";
  EXPECT_EQ(send(1, 3, s_.roster.now), 0U) << "one is missing before it";
  EXPECT_TRUE(rules_.busy());
  EXPECT_EQ(send(1, 2, s_.roster.now - node::kSilence), 3U) << "all that came, in several datagrams";
  EXPECT_FALSE(rules_.busy());
  EXPECT_FALSE(s_.roster.seats[3].frozen);
}

}  // namespace
}  // namespace padr::test
