// Who vouches for a peer that the coordinator takes for lost, and with what evidence, as tables.
#include "common/membership/misbehaviour_policy.h"
#include "common/membership/vouching.h"
#include "common/paths/relay.h"
#include "tests/membership/rules.h"

#include <memory>

namespace padr::test {
namespace {

using node::Vouching;

/// Peer 0 polls about peer 2. Peer 1 vouches, or not.
class Vouched : public testing::Test {
 protected:
  bool polls(bool freeze = true) {
    out_ = std::make_unique<ListedCommands>();
    const wire::Poll poll{{{2, s_.roster.seats[2].incarnation, 1, 0}}, freeze, 0};
    return rules_.vouches(0, poll, s_.view(), s_.roster.now, 0, misbehaviour_, relay_, *out_);
  }
  std::vector<wire::Fetched> evidence() const {
    std::vector<wire::Fetched> sent;
    for (const auto& f : out_->all<wire::Fetched>())
      if (f.to == Situation::at(0)) sent.push_back(f.message);
    return sent;
  }
  void pass(Tick ticks) {
    s_.roster.now += ticks;
    s_.log.mark(2, s_.roster.now, s_.log.have(2));
    s_.roster.seats[2].heard = s_.roster.seats[2].answered = s_.roster.seats[2].answer_mark = s_.roster.now;
  }

  /// For as long as that is believed, peer 0 does not hear peer 2.
  void asks_in_vain() {
    for (Tick t = 0; t < node::Relay::kUnheardForLong; t += 60) {
      relay_.on_fetch(0, {2, s_.roster.seats[2].incarnation, 0}, s_.view(), *out_);
      EXPECT_TRUE(polls()) << t;
      pass(60);
      s_.tells(2, s_.log.have(2), s_.roster.now - 1);
      s_.log.mark(2, s_.roster.now, s_.log.have(2));
    }
  }

  Situation s_{4, 1};
  node::MisbehaviourPolicy misbehaviour_{s_.session};
  node::Relay relay_{s_.session};
  Vouching rules_{s_.session};
  std::unique_ptr<ListedCommands> out_ = std::make_unique<ListedCommands>();
};

TEST_F(Vouched, WhoIsVouchedFor) {
  struct Row {
    const char* name;
    bool freeze;
    void (*change)(Situation&);
    bool vouched;
  };
  const Row rows[] = {
      {"heard just now", true, [](Situation&) {}, true},
      {"it is only asked who hears it", false, [](Situation&) {}, false},
      {"not heard for long", true, [](Situation& s) { s.silence(2, kNow - node::kHeardLately); }, false},
      {"a tick less long", true, [](Situation& s) { s.silence(2, kNow - node::kHeardLately + 1); }, true},
      {"another incarnation", true, [](Situation& s) { ++s.roster.seats[2].incarnation; }, true},
      {"gone", true, [](Situation& s) { s.empty(2); }, false},
      {"given up", true, [](Situation& s) { s.roster.give_up(2, false); }, false},
      {"its eviction is under way for another", true, [](Situation& s) { s.roster.seats[2].frozen = true; }, false},
      {"it owes updates", true, [](Situation& s) { s.log.begin(2, 1, kNow - node::kRelayAfter); }, false},
      {"it acknowledges nothing", true,
       [](Situation& s) { s.roster.seats[2].unacknowledged = kNow - node::View::kArrears; }, false},
  };
  for (const Row& r : rows) {
    s_ = Situation(4, 1);
    r.change(s_);
    EXPECT_EQ(polls(r.freeze), r.vouched) << r.name;
  }
}

// In which it asks the peer for something signed.
TEST_F(Vouched, WithoutEvidenceOnlyForAWhile) {
  EXPECT_TRUE(polls());
  EXPECT_TRUE(evidence().empty());
  const auto asked = out_->all<wire::Poll>();
  ASSERT_EQ(asked.size(), 1U);
  EXPECT_EQ(asked[0].to, Situation::at(2));
  EXPECT_EQ(asked[0].message.lost[0].slot, 2);
  EXPECT_FALSE(asked[0].message.freeze);
  pass(Vouching::kGrace - 1);
  EXPECT_TRUE(polls());
  pass(1);
  EXPECT_FALSE(polls());
  pass(2 * Vouching::kGrace + 1);
  EXPECT_TRUE(polls()) << "it is another occasion";
}

TEST_F(Vouched, WithEvidenceAsLongAsThereIsSome) {
  s_.log.begin(2, 1, kNow - 50);
  s_.tells(2, 1, kNow - 3);
  s_.log.mark(2, kNow, 2);
  EXPECT_TRUE(polls());
  ASSERT_EQ(evidence().size(), 1U);
  ASSERT_EQ(evidence()[0].updates.size(), 1U);
  EXPECT_EQ(evidence()[0].updates[0].index, 1U);
  pass(node::kHeardLately - 4);
  EXPECT_TRUE(polls());
  pass(1);
  EXPECT_FALSE(polls()) << "it is from before it can have fallen silent";
  s_.tells(2, 2, s_.roster.now);
  s_.log.mark(2, s_.roster.now, 3);
  EXPECT_TRUE(polls());
}

// Both must keep their updates for each other, so one of them has to go. With a key others carry for the two, and the
// asker may lie.
TEST_F(Vouched, NotForEverIfTheAskerNeverHearsItButWithAKey) {
  for (const bool sealed : {false, true}) {
    s_.session.config.sealed = sealed;
    asks_in_vain();
    EXPECT_EQ(polls(), sealed);
    pass(node::Relay::kAsksOn);
    EXPECT_TRUE(polls()) << "it has heard it meanwhile";
  }
}

// It is as long as a datagram may be, and the question for it is short.
TEST_F(Vouched, WithNoMoreEvidenceThanTheAskersShare) {
  s_.log.begin(2, 1, kNow - 50);
  s_.tells(2, 1, kNow - 3);
  s_.log.mark(2, kNow, 2);
  std::size_t shown = 0;
  const auto ask = [&] {
    for (int i = 0; i < 10 * node::Relay::kServed; ++i) {
      EXPECT_TRUE(polls());
      shown += evidence().size();
    }
  };
  ask();
  EXPECT_EQ(shown, static_cast<std::size_t>(node::Relay::kServed));
  pass(node::Relay::kPace);
  ask();
  EXPECT_EQ(shown, static_cast<std::size_t>(2 * node::Relay::kServed));
}

TEST(ProveAlive, WhoIsAskedPublishesAnUpdateButNotOften) {
  Situation s(4, 2);
  Vouching rules(s.session);
  const auto asked = [&](PeerId slot, std::uint32_t incarnation) {
    ListedCommands out;
    rules.prove_alive({{{slot, incarnation, 0, 0}}, false, 0}, s.view(), out);
    return out.orders.size();
  };
  EXPECT_EQ(asked(1, 2), 0U);
  EXPECT_EQ(asked(2, 4), 0U) << "a former incarnation";
  EXPECT_EQ(asked(2, 3), 1U);
  EXPECT_EQ(asked(2, 3), 0U);
  s.roster.now += Vouching::kPace;
  EXPECT_EQ(asked(2, 3), 1U);
}

}  // namespace
}  // namespace padr::test
