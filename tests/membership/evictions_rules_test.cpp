// Who coordinates, who follows, and what an eviction asks and orders: tables of what is seen and what is to be done.
#include "common/membership/evictions.h"

#include "common/membership/misbehaviour_policy.h"
#include "tests/membership/rules.h"

namespace padr::test {
namespace {

using node::Evictions;
using node::SessionEvent;

TEST(EvictionRules, TheCoordinatorIsTheLowestThatLives) {
  struct Row {
    std::string name;
    PeerId self;
    void (*change)(Situation&);
    PeerId coordinator;
  };
  const std::vector<Row> rows{
      {"all live", 2, [](Situation&) {}, 0},
      {"the lowest has gone", 2, [](Situation& s) { s.empty(0); }, 1},
      {"the lowest has left", 2, [](Situation& s) { s.roster.seats[0].presence = node::Presence::kLeft; }, 1},
      {"the lowest is silent", 2, [](Situation& s) { s.silence(0, kLongAgo); }, 1},
      {"a tick short of silence", 2, [](Situation& s) { s.silence(0, kLongAgo + 1); }, 0},
      {"the lowest is relayed", 2,
       [](Situation& s) {
         s.silence(0, kLongAgo);
         s.roster.seats[0].relayed = kNow;
       },
       0},
      {"the lowest is given up", 2, [](Situation& s) { s.roster.give_up(0, false); }, 1},
      {"this peer is the lowest", 0, [](Situation&) {}, 0},
      {"it is, but leaves", 0, [](Situation& s) { s.roster.leaving = true; }, 1},
      {"it is, but is no member yet", 0, [](Situation& s) { s.roster.member = false; }, 1},
      {"nobody else lives", 1,
       [](Situation& s) {
         for (const PeerId p : {PeerId{0}, PeerId{2}, PeerId{3}}) s.empty(p);
         s.roster.leaving = true;
       },
       kNoPeer},
  };
  for (const Row& r : rows) {
    Situation s(4, r.self);
    r.change(s);
    EXPECT_EQ(Evictions(s.session).coordinator(s.view()), r.coordinator) << r.name;
  }
}

TEST(EvictionRules, WhoFollowsAPollFreezesWhomItIsAbout) {
  struct Row {
    std::string name;
    PeerId asker;
    bool freeze;
    void (*change)(Situation&);
    Tick behind;
    bool follows;
  };
  const auto nothing = [](Situation&) {};
  // Peer 3 asks about peer 2 and, where peer 0 or 1 seem to live, about those, too.
  const std::vector<Row> rows{
      {"the coordinator asks", 0, true, nothing, 0, true},
      {"it asks only who hears it", 0, false, nothing, 0, false},
      {"the coordinator is well", 1, true, nothing, 0, false},
      {"the coordinator is silent", 1, true, [](Situation& s) { s.silence(0, kLongAgo); }, 0, true},
      {"it seems to live, by an excuse alone", 1, true,
       [](Situation& s) {
         s.silence(0, kNow - node::kHeardLately);
         s.roster.seats[0].excused = kNow - 1;
       },
       0, true},
      {"excused, but heard since", 1, true,
       [](Situation& s) {
         s.silence(0, kNow - node::kHeardLately + 1);
         s.roster.seats[0].excused = kNow - 1;
       },
       0, false},
      {"heard long ago, but no excuse", 1, true, [](Situation& s) { s.silence(0, kNow - node::kHeardLately); }, 0,
       false},
      {"this peer was held up, and reads before it steps", 1, true,
       [](Situation& s) { s.silence(0, kNow - node::kHeardLately + 3); }, 3 * kTicksPerSecond, true},
      {"held up, but what it read meanwhile is new", 1, true,
       [](Situation& s) { s.roster.seats[0].answer_mark = kNow + 100; }, 3 * kTicksPerSecond, false},
      {"the asker is silent itself", 1, true,
       [](Situation& s) {
         s.silence(0, kLongAgo);
         s.silence(1, kLongAgo);
       },
       0, false},
  };
  for (const Row& r : rows) {
    Situation s(4, 3);
    r.change(s);
    Evictions rules(s.session);
    wire::Poll poll{{}, r.freeze, 0};
    if (r.asker == 1) poll.lost.push_back(s.named(0));
    poll.lost.push_back(s.named(2));
    ListedCommands out;
    rules.on_poll(r.asker, poll, s.view(), kNow + r.behind, out);
    EXPECT_EQ(std::count(out.freezes.begin(), out.freezes.end(), std::pair(PeerId{2}, true)), r.follows ? 1 : 0)
        << r.name;
    const auto answers = out.all<wire::Answer>();
    ASSERT_EQ(answers.size(), 1U) << r.name;
    EXPECT_EQ(answers[0].to, Situation::at(r.asker)) << r.name;
    EXPECT_EQ(answers[0].message.frozen, r.follows) << r.name;
    EXPECT_EQ(rules.answered(r.asker, 2), r.follows) << r.name;
  }
}

TEST(EvictionRules, AHigherNumberTakesBackAndALowerOneIsOld) {
  Situation s(4, 3);
  Evictions rules(s.session);
  const auto poll = [&](bool freeze, std::uint32_t number) {
    ListedCommands out;
    rules.on_poll(0, {{s.named(2)}, freeze, number}, s.view(), kNow, out);
    s.follow(out);
    return out.all<wire::Answer>().size();
  };
  EXPECT_EQ(poll(true, 1), 1U);
  EXPECT_TRUE(s.roster.seats[2].frozen);
  EXPECT_EQ(poll(true, 0), 0U) << "it was under way for longer";
  EXPECT_EQ(poll(false, 2), 1U);
  EXPECT_FALSE(rules.answered(0, 2));
  ListedCommands out;
  rules.advance(s.view(), out);
  s.follow(out);
  EXPECT_FALSE(s.roster.seats[2].frozen) << "nobody asks about it any more";
}

TEST(EvictionRules, AQuestionAboutAnotherIncarnationFreezesNobody) {
  Situation s(4, 3);
  Evictions rules(s.session);
  wire::Seat former = s.named(2);
  former.incarnation -= 1;
  ListedCommands out;
  rules.on_poll(0, {{former}, true, 0}, s.view(), kNow, out);
  EXPECT_TRUE(out.freezes.empty());
  EXPECT_TRUE(rules.answered(0, 2, former.incarnation));
  EXPECT_FALSE(rules.answered(0, 2, former.incarnation + 1));
}

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
  sync::Bundle last;
  last.peer = 3;
  last.index = 1;
  last.tick = kNow - 200;
  rules_.on_fetched({3, 4, {last}}, s_.view(), node::MisbehaviourPolicy(s_.session));
  pass(1);
  ASSERT_EQ(orders_.size(), 2U);
  ASSERT_EQ(orders_[0].passed_on.size(), 1U);
  EXPECT_EQ(orders_[0].passed_on[0].index, 1U) << "peer 1 lacks it, and so did this one";
  ASSERT_EQ(orders_[1].removals.size(), 1U);
  EXPECT_EQ(orders_[1].removals[0], (sync::Removal{3, 4, 2}));
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

TEST_F(Eviction, NamesWhoWithholdsItsReply) {
  begin();
  reply(1, true, 1, -1);
  pass(Evictions::kWithheld - 1);
  EXPECT_TRUE(rules_.withholding(s_.view()).empty());
  pass(2);
  EXPECT_EQ(rules_.withholding(s_.view()), std::vector<PeerId>{2});
  s_.roster.seats[2].excused = s_.roster.now;
  EXPECT_TRUE(rules_.withholding(s_.view()).empty()) << "who was held up could not hear the replies";
}

}  // namespace
}  // namespace padr::test
