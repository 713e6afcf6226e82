// Who coordinates, who follows a poll, and for how long: tables of what is seen and what is to be done.
#include "common/membership/evictions.h"

#include "tests/membership/rules.h"

namespace padr::test {
namespace {

using node::Evictions;

TEST(EvictionRules, TheCoordinatorIsTheMostSeniorThatLives) {
  struct Row {
    std::string name;
    PeerId self;
    void (*change)(Situation&);
    PeerId coordinator;
  };
  const std::vector<Row> rows{
      {"all live", 2, [](Situation&) {}, 0},
      {"a newcomer has the lowest slot", 2, [](Situation& s) { s.roster.seats[0].incarnation = 9; }, 1},
      {"the most senior has gone", 2, [](Situation& s) { s.empty(0); }, 1},
      {"the most senior has left", 2, [](Situation& s) { s.roster.seats[0].presence = node::Presence::kLeft; }, 1},
      {"the most senior is silent", 2, [](Situation& s) { s.silence(0, kLongAgo); }, 1},
      {"a tick short of silence", 2, [](Situation& s) { s.silence(0, kLongAgo + 1); }, 0},
      {"the most senior is relayed", 2,
       [](Situation& s) {
         s.silence(0, kLongAgo);
         s.roster.seats[0].relayed = kNow;
       },
       0},
      {"the most senior is given up", 2, [](Situation& s) { s.roster.give_up(0, false); }, 1},
      {"this peer is the most senior", 0, [](Situation&) {}, 0},
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
      {"a newcomer, which nobody has answered yet", 1, true,
       [](Situation& s) {
         s.silence(0, kNow - node::kHeardLately);
         s.roster.seats[0].excused = kNow - 1;
         s.roster.seats[0].answer_mark = -1;
       },
       0, false},
      {"the same, held up as it catches up", 1, true,
       [](Situation& s) {
         s.silence(0, kNow - node::kHeardLately);
         s.roster.seats[0].answer_mark = -1;
       },
       node::kSilence - 2, false},
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
    rules.on_poll(r.asker, poll, s.view(), kNow + r.behind, false, out);
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
    rules.on_poll(0, {{s.named(2)}, freeze, number}, s.view(), kNow, false, out);
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

// A coordinator polled with high numbers about a living member, and then honestly about a lost one with its own: once,
// nobody replied to it any more, and all were left out of the eviction.
TEST(EvictionRules, ALowerNumberCountsAgainIfNoPollWithTheHigherOneHasComeForLong) {
  Situation s(4, 3);
  Evictions rules(s.session);
  const auto poll = [&](PeerId about, std::uint32_t number) {
    ListedCommands out;
    rules.on_poll(0, {{s.named(about)}, true, number}, s.view(), s.roster.now, false, out);
    s.follow(out);
    const auto answers = out.all<wire::Answer>();
    return !answers.empty() && answers[0].message.number == number;
  };
  const Tick polled = s.roster.now;
  EXPECT_TRUE(poll(1, 5));
  s.roster.now = polled + Evictions::kLease - 1;
  EXPECT_FALSE(poll(2, 0));
  s.roster.now = polled + Evictions::kLease;
  EXPECT_TRUE(poll(2, 0));
  EXPECT_TRUE(rules.answered(0, 2));
  EXPECT_FALSE(rules.answered(0, 1));
}

TEST(EvictionRules, AQuestionAboutAnotherIncarnationFreezesNobody) {
  Situation s(4, 3);
  Evictions rules(s.session);
  wire::Seat former = s.named(2);
  former.incarnation -= 1;
  ListedCommands out;
  rules.on_poll(0, {{former}, true, 0}, s.view(), kNow, false, out);
  EXPECT_TRUE(out.freezes.empty());
  EXPECT_TRUE(rules.answered(0, 2, former.incarnation));
  EXPECT_FALSE(rules.answered(0, 2, former.incarnation + 1));
}

// Once, a newcomer said so of a liar which had kept back an update from all others for long, and the eviction came
// later than they wait for something to be confirmed.
TEST(EvictionRules, ANewcomerDoesNotHearWhoWithheldUpdatesBeforeItCame) {
  struct Row {
    const char* name;
    Tick complete;
    std::uint32_t first;
    bool heard;
  };
  const Row rows[] = {
      {"all is here", kNow - 1, 0, true},
      {"something is missing, but not for long", kNow - node::View::kArrears + 1, 0, true},
      {"something has been missing for long", kNow - node::View::kArrears, 0, false},
      {"what is missing is a former occupant's", kNow - node::View::kArrears, 5, true},
  };
  for (const Row& r : rows) {
    Situation s(4, 1);
    s.log.begin(2, 0, r.complete);
    s.roster.seats[2].first = r.first;
    s.roster.seats[2].excused = kNow - 10;  // when this peer came
    node::Evictions rules(s.session);
    ListedCommands out;
    rules.on_poll(0, {{s.named(2)}, false, 0}, s.view(), kNow, false, out);
    ASSERT_EQ(out.all<wire::Answer>().size(), 1U) << r.name;
    EXPECT_EQ(out.all<wire::Answer>()[0].message.lost[0].heard > 0, r.heard) << r.name;
  }
}

// A lie froze a peer for good once: its updates were dropped for ever, until it cut this peer off in turn.
TEST(EvictionRules, AFrozenPeerThatIsHeardAgainIsTakenBackFromAnAskerThatLies) {
  struct Row {
    std::string name;
    bool sealed;
    bool polls_on;
    bool tells_on;  ///< the asker's marks go on coming
    bool thaws;
    bool catches_up = false;
  };
  const std::vector<Row> rows{
      {"it polls on", true, true, true, true},
      {"it neither polls on nor gives its order", true, false, true, true},
      {"this peer has stood still, and the polls wait to be read", true, false, true, false, true},
      {"it has fallen silent, and may have given its order", true, false, false, false},
      {"without a key nobody lies, but it may be slow", false, true, true, false},
  };
  for (const Row& r : rows) {
    Situation s(4, 3);
    s.session.config.sealed = r.sealed;
    Evictions rules(s.session);
    s.silence(2, kLongAgo);
    bool contested = false;
    bool thawed = false;
    const auto pass = [&](Tick ticks) {
      for (Tick t = 0; t < ticks; ++t) {
        s.roster.seats[0].heard = s.roster.seats[0].answered = s.roster.seats[0].answer_mark = s.roster.now;
        if (s.roster.seats[2].frozen) s.roster.note_answer_of_frozen(2);
        if (r.tells_on) s.log.mark(0, s.roster.now, 0);
        if (r.catches_up) s.roster.late = s.roster.now - 1;
        ListedCommands out;
        if (r.polls_on || s.roster.now == kNow)
          rules.on_poll(0, {{s.named(2)}, true, 0}, s.view(), s.roster.now, false, out);
        for (const auto& answer : out.all<wire::Answer>())
          contested |= !answer.message.frozen && answer.message.lost[0].heard > 0;
        rules.advance(s.view(), out);
        s.follow(out);
        thawed |= !rules.answered(0, 2);
      }
    };
    pass(Evictions::kHeardAgain);
    EXPECT_TRUE(s.roster.seats[2].frozen) << r.name;
    EXPECT_FALSE(contested) << r.name;
    pass(Evictions::kLease + 3);
    EXPECT_EQ(contested, r.polls_on) << r.name;
    EXPECT_EQ(thawed, r.thaws) << r.name;
  }
}

}  // namespace
}  // namespace padr::test
