// Whose updates are asked for, of whom, and who is served.
#include "common/paths/relay.h"
#include "tests/membership/rules.h"

namespace padr::test {
namespace {

using node::Relay;

TEST(RelayRules, WhoIsAskedAboutWhom) {
  struct Row {
    std::string name;
    void (*change)(Situation&);
    PeerId asked;  ///< the first; kNoPeer: nobody
    PeerId about;
  };
  const std::vector<Row> rows{
      {"all are heard", [](Situation&) {}, kNoPeer, 0},
      {"one is not heard", [](Situation& s) { s.silence(2, kNow - node::kRelayAfter); }, 1, 2},
      {"a tick short", [](Situation& s) { s.silence(2, kNow - node::kRelayAfter + 1); }, kNoPeer, 0},
      {"heard, but it does not tell what it promised",
       [](Situation& s) { s.log.begin(2, 0, kNow - node::kRelayAfter); }, 1, 2},
      {"it has been given up, but others may have heard its farewell",
       [](Situation& s) {
         s.silence(2, kNow - node::kRelayAfter);
         s.roster.give_up(2, true);
       },
       1, 2},
      {"it is being evicted",
       [](Situation& s) {
         s.silence(2, kNow - node::kRelayAfter);
         s.roster.seats[2].frozen = true;
       },
       kNoPeer, 0},
      {"the one to ask is not heard either", [](Situation& s) { s.silence(1, kNow - node::kRelayAfter); }, 2, 1},
      {"this peer is no member yet",
       [](Situation& s) {
         s.silence(2, kNow - node::kRelayAfter);
         s.roster.member = false;
       },
       kNoPeer, 0},
      {"silent for so long that nothing is kept for it",
       [](Situation& s) {
         for (PeerId p = 0; p < 4; ++p) s.log.begin(p, 0, 20'000);
         s.roster.now = 20'000;
         for (PeerId p = 1; p < 4; ++p) s.silence(p, 20'000);
         s.silence(2, 20'000 - node::kRelayUntil);
       },
       kNoPeer, 0},
  };
  for (const Row& r : rows) {
    Situation s(4, 0);
    r.change(s);
    ListedCommands out;
    Relay(s.session).advance(s.view(), out);
    const auto asked = out.all<wire::Fetch>();
    ASSERT_EQ(asked.size(), r.asked == kNoPeer ? 0U : 1U) << r.name;
    if (r.asked == kNoPeer) continue;
    EXPECT_EQ(asked[0].to, Situation::at(r.asked)) << r.name;
    EXPECT_EQ(asked[0].message.slot, r.about) << r.name;
  }
}

TEST(RelayRules, ServesWhatIsHereAndNoMoreThanItsShare) {
  Situation s(4, 0);
  s.tells(2, 0, 900);
  Relay rules(s.session);
  ListedCommands out;
  rules.on_fetch(1, {2, s.roster.seats[2].incarnation + 1, 0}, s.view(), out);
  rules.on_fetch(1, {2, s.roster.seats[2].incarnation, 1}, s.view(), out);
  rules.on_fetch(1, {0, s.roster.incarnation, 0}, s.view(), out);
  EXPECT_TRUE(out.all<wire::Fetched>().empty()) << "another incarnation, nothing new, and this peer's own";
  for (int i = 0; i < 2 * Relay::kServed; ++i) rules.on_fetch(1, {2, s.roster.seats[2].incarnation, 0}, s.view(), out);
  EXPECT_EQ(out.all<wire::Fetched>().size(), static_cast<std::size_t>(Relay::kServed));
  s.roster.now += Relay::kPace;
  rules.on_fetch(1, {2, s.roster.seats[2].incarnation, 0}, s.view(), out);
  EXPECT_EQ(out.all<wire::Fetched>().size(), static_cast<std::size_t>(Relay::kServed) + 1);
}

// Once, nobody sent the last orders of a coordinator that had left, and whoever had been out of reach refused the next
// one's, which rested on them.
TEST(RelayRules, ServesWhatWhoIsGoneHasSaidAndNothingOfWhoSitsThereNow) {
  Situation s(4, 0);
  s.tells(2, 0, 900);
  const std::uint32_t gone = s.roster.seats[2].incarnation;
  const auto served = [&](std::uint32_t incarnation) {
    ListedCommands out;
    Relay(s.session).on_fetch(1, {2, incarnation, 0}, s.view(), out);
    return out.all<wire::Fetched>();
  };
  s.roster.seats[2].presence = node::Presence::kAbsent;
  ASSERT_EQ(served(gone).size(), 1U) << "removed";
  EXPECT_EQ(served(gone)[0].message.updates.size(), 1U);

  s.roster.seat(2, gone + 40, 1, {}, 910);
  s.tells(2, 1, 920);
  ASSERT_EQ(served(gone).size(), 1U) << "another one sits there";
  EXPECT_EQ(served(gone)[0].message.updates.size(), 1U);
  EXPECT_EQ(served(gone)[0].message.updates[0].index, 0U);
  EXPECT_EQ(served(gone)[0].message.incarnation, gone);

  s.roster.seat(2, gone + 80, 2, {}, 930);
  s.tells(2, 2, 940);
  ASSERT_EQ(served(gone + 40).size(), 1U) << "two have sat there";
  EXPECT_EQ(served(gone + 40)[0].message.updates.front().index, 0U) << "what is asked for, from the first on";
  EXPECT_EQ(served(gone + 40)[0].message.updates.back().index, 1U);
  EXPECT_TRUE(served(gone + 41).empty()) << "nobody with that incarnation";
}

// Once, a coordinator that had made this peer freeze another one got a datagram of updates for each Fetch.
TEST(RelayRules, ServesWhoGathersWhatALostPeerHasToldNoMoreThanItsShareEither) {
  Situation s(4, 0);
  s.tells(2, 0, 900);
  s.roster.seats[2].frozen = true;
  Relay rules(s.session);
  ListedCommands out;
  for (int i = 0; i < 2 * Relay::kServed; ++i) rules.on_fetch(1, {2, s.roster.seats[2].incarnation, 0}, s.view(), out);
  EXPECT_EQ(out.all<wire::Fetched>().size(), static_cast<std::size_t>(Relay::kServed));
}

/// Peer 0 of four has not heard peer 2 for so long that it asks the others for its updates.
struct Lacking {
  Lacking() {
    s.silence(2, kNow - node::kRelayAfter);
    sync::Bundle b;
    b.peer = 2;
    reply = {2, s.roster.seats[2].incarnation, {b}};
  }
  std::size_t taken_from(PeerId by) {
    rules.on_fetched(by, reply, s.view(), out);
    return out.relayed.size();
  }

  Situation s{4, 0};
  Relay rules{s.session};
  wire::Fetched reply;
  ListedCommands out;
};

TEST(RelayRules, TakesOnlyWhatItHasAskedFor) {
  Lacking peer;
  EXPECT_EQ(peer.taken_from(1), 0U) << "nobody was asked";
  peer.rules.advance(peer.s.view(), peer.out);
  EXPECT_EQ(peer.taken_from(3), 0U) << "another one was asked";
  EXPECT_EQ(peer.taken_from(1), 1U);
  EXPECT_EQ(peer.taken_from(1), 1U) << "once";
}

// Once, each question made this peer ignore the reply to the one before: where a reply took longer than kPace, nothing
// was relayed, and members cut each other off.
TEST(RelayRules, TakesAReplyAlsoWhenTheNextMemberHasBeenAsked) {
  Lacking peer;
  peer.rules.advance(peer.s.view(), peer.out);
  peer.s.roster.now += Relay::kPace;
  peer.rules.advance(peer.s.view(), peer.out);
  const auto asked = peer.out.all<wire::Fetch>();
  ASSERT_EQ(asked.size(), 2U);
  EXPECT_EQ(asked[0].to, Situation::at(1));
  EXPECT_EQ(asked[1].to, Situation::at(3));
  EXPECT_EQ(peer.taken_from(1), 1U);
  peer.s.roster.now += Relay::kPatience + 1;
  EXPECT_EQ(peer.taken_from(3), 1U) << "that is too late";
}

}  // namespace
}  // namespace padr::test
