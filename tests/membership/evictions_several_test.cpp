// What becomes of evictions when several peers fall silent at once, and some are heard again.
#include "common/membership/evictions.h"

#include "tests/membership/rules.h"

namespace padr::test {
namespace {

using node::Evictions;
using node::SessionEvent;

// One of the two is silent, too, when the first is asked about; later this peer hears it, and it is more senior.
TEST(EvictionRules, AreHandedOverToWhoIsMoreSeniorAndHeardAgain) {
  Situation s(5, 1);
  Evictions rules(s.session);
  ListedCommands all;
  const auto pass = [&](Tick ticks) {
    for (Tick t = 0; t < ticks; ++t) {
      for (const PeerId p : {PeerId{2}, PeerId{3}}) s.silence(p, s.roster.now);
      ListedCommands out;
      rules.advance(s.view(), out);
      s.follow(out);
      for (const auto& [to, poll] : out.all<wire::Poll>()) {
        if (to != Situation::at(2) && to != Situation::at(3)) continue;
        wire::Answer reply{poll.lost, false, s.roster.now, poll.number};
        for (wire::Seat& about : reply.lost) about.heard = about.slot == 0 ? 1 : 0;
        ListedCommands then;
        rules.on_answer(to == Situation::at(2) ? 2 : 3, reply, s.view(), then);
      }
      all.events.insert(all.events.end(), out.events.begin(), out.events.end());
    }
  };
  for (const PeerId p : {PeerId{0}, PeerId{4}}) s.silence(p, kNow - node::kDoubt);
  pass(node::kSilence - node::kDoubt + 1);
  ASSERT_TRUE(s.roster.seats[4].frozen);
  ASSERT_FALSE(s.roster.seats[0].frozen) << "the others hear it";
  s.silence(0, s.roster.now);
  pass(2);
  EXPECT_FALSE(rules.busy());
  EXPECT_FALSE(s.roster.seats[4].frozen) << "that one will ask";
  EXPECT_FALSE(all.told(SessionEvent::Kind::kHeardAgain)) << "it is not";
}

struct Step {
  bool evicts = false;
  bool takes_back = false;
};

/// A tick in which peers 1 and 2 are heard, and those of `replying` reply to each poll. Peer 1 hears peer 4.
Step step_with_veto(Situation& s, Evictions& rules, PeerSet replying) {
  Step step;
  for (const PeerId p : {PeerId{1}, PeerId{2}}) s.silence(p, s.roster.now);
  ListedCommands out;
  rules.advance(s.view(), out);
  s.follow(out);
  for (const auto& order : out.orders) step.evicts = step.evicts || !order.removals.empty();
  for (const auto& [to, poll] : out.all<wire::Poll>()) {
    for (PeerId p = 0; p < s.roster.slots(); ++p) {
      if (to != Situation::at(p) || (replying & only(p)) == 0) continue;
      wire::Answer reply{poll.lost, poll.freeze, s.roster.now, poll.number};
      for (wire::Seat& about : reply.lost) {
        if (!poll.freeze || about.slot != 4 || p != 1) continue;
        reply.frozen = false;
        about.heard = 5;
      }
      ListedCommands then;
      rules.on_answer(p, reply, s.view(), then);
      step.takes_back = step.takes_back || then.told(SessionEvent::Kind::kHeardAgain);
    }
  }
  return step;
}

// Peer 3 is lost, and peer 2 does not reply. Peer 4 falls silent again and again, and each time peer 1 hears it. Once,
// each take-back gave peer 2 its whole time again, so that peer 3 was never evicted and nobody let in.
TEST(EvictionRules, VetoesAboutOnePeerGiveNobodyMoreTimeToReplyAboutAnother) {
  Situation s(5, 0);
  Evictions rules(s.session);
  for (const PeerId p : {PeerId{3}, PeerId{4}}) s.silence(p, kNow - node::kDoubt);
  int vetoes = 0;
  Tick evicted = 0;
  Tick lost = 0;
  for (Tick t = 0; t < 2 * Evictions::kWithheld && evicted == 0; ++t) {
    const Step step = step_with_veto(s, rules, only(1));
    if (lost == 0 && s.roster.seats[3].frozen) lost = s.roster.now;
    if (step.evicts) evicted = s.roster.now;
    if (!step.takes_back) continue;
    ++vetoes;
    s.silence(4, s.roster.now);
  }
  EXPECT_GE(vetoes, 2);
  ASSERT_GT(evicted, 0);
  EXPECT_LE(evicted - lost, Evictions::kWithheld + node::kAnswerPatience + node::kSilence);
}

// Peers 3 and 4 are silent, and peer 1 hears peer 4. Peer 3 may be the cause: if it had others freeze peer 4 and then
// ended, they take nothing from peer 4 until it is out. Once, peer 4 was polled about again at once, and neither ever
// was.
TEST(EvictionRules, AfterATakeBackTheOthersThatAreLostAreEvictedFirst) {
  Situation s(5, 0);
  Evictions rules(s.session);
  for (const PeerId p : {PeerId{3}, PeerId{4}}) s.silence(p, kNow - node::kDoubt);
  Tick taken_back = 0;
  Tick evicted = 0;
  for (Tick t = 0; t < 2 * node::kSilence && evicted == 0; ++t) {
    const Step step = step_with_veto(s, rules, only(1) | only(2) | only(4));
    if (step.evicts) evicted = s.roster.now;
    if (step.takes_back && taken_back == 0) taken_back = s.roster.now;
  }
  ASSERT_GT(taken_back, 0);
  ASSERT_GT(evicted, 0);
  EXPECT_LE(evicted - taken_back, node::kAnswerPatience);
  EXPECT_FALSE(s.roster.seats[4].frozen);
}

}  // namespace
}  // namespace padr::test
