// Who gets which slot, what a joiner is sent, and what is ordered when it comes in.
#include "common/membership/admissions.h"
#include "tests/membership/rules.h"

namespace padr::test {
namespace {

using node::Admissions;

constexpr Micros kLocal = 5'000'000;

wire::Join join(std::uint64_t nonce) {
  wire::Join j;
  j.nonce = nonce;
  return j;
}

Endpoint joiner(int n) {
  return ipv4({10, 0, 1, static_cast<std::uint8_t>(n)}, 7000);
}

TEST(AdmissionRules, TheLowestSlotThatIsFree) {
  struct Row {
    std::string name;
    void (*change)(Situation&);
    PeerId slot;  ///< kNoPeer: none
    bool refused;
  };
  const std::vector<Row> rows{
      {"all are taken", [](Situation&) {}, kNoPeer, true},
      {"one is silent: its slot may come free", [](Situation& s) { s.silence(2, kNow - 61); }, kNoPeer, false},
      {"one has been removed", [](Situation& s) { s.empty(2); }, 2, false},
      {"two have",
       [](Situation& s) {
         s.empty(3);
         s.empty(1);
       },
       1, false},
      {"removed, but not all of its updates are known",
       [](Situation& s) {
         s.roster.seats[2].presence = node::Presence::kAbsent;
         s.log.close(2, 3);
         s.log.mark(2, 900, 3);
       },
       kNoPeer, false},
      {"left, and lingers",
       [](Situation& s) {
         s.empty(2);
         s.roster.seats[2].presence = node::Presence::kLeft;
       },
       kNoPeer, false},
      {"left, and is gone",
       [](Situation& s) {
         s.empty(2);
         s.silence(2, kNow - node::Roster::kDeparted - 1);
         s.roster.seats[2].presence = node::Presence::kLeft;
       },
       2, false},
  };
  for (const Row& r : rows) {
    Situation s(4, 0);
    r.change(s);
    Admissions rules(s.session);
    ListedCommands out;
    rules.on_join(joiner(1), join(5), s.view(), kLocal, out);
    const auto welcomes = out.all<wire::Welcome>();
    EXPECT_EQ(welcomes.empty() ? kNoPeer : welcomes[0].message.peer, r.slot) << r.name;
    EXPECT_EQ(out.all<wire::Refuse>().size(), r.refused ? 1U : 0U) << r.name;
  }
}

TEST(AdmissionRules, MembersThatReturnAreKnownByTheirKeys) {
  Situation s(4, 0);
  s.empty(3);
  Endpoint at = Situation::at(1);
  at.key[0] = 7;
  s.roster.seats[1].at = at;
  Admissions rules(s.session);
  ListedCommands out;
  EXPECT_EQ(rules.returning(s.view()), 0U);
  rules.on_join(Situation::at(2), join(4), s.view(), kLocal, out);
  EXPECT_EQ(rules.returning(s.view()), 0U) << "without a key anybody could ask in its name";
  rules.advance(kLocal + Admissions::kUnproven + 1);
  rules.on_join(at, join(5), s.view(), kLocal, out);
  EXPECT_EQ(rules.returning(s.view()), only(1));
  rules.advance(kLocal + Admissions::kUnproven + 1);
  EXPECT_EQ(rules.returning(s.view()), 0U) << "it no longer asks";
}

TEST(AdmissionRules, NobodyGetsAnIncarnationThatIsKnown) {
  Situation s(4, 0);
  s.empty(2);
  s.empty(3);
  s.roster.seats[1].incarnation = 900;
  Admissions rules(s.session);
  ListedCommands out;
  rules.on_join(joiner(1), join(5), s.view(), kLocal, out);
  rules.on_join(joiner(2), join(6), s.view(), kLocal, out);
  rules.on_join(joiner(1), join(5), s.view(), kLocal, out);
  const auto welcomes = out.all<wire::Welcome>();
  ASSERT_EQ(welcomes.size(), 3U);
  EXPECT_GT(welcomes[0].message.incarnation, 900U);
  EXPECT_GT(welcomes[1].message.incarnation, welcomes[0].message.incarnation);
  EXPECT_EQ(welcomes[2].message, welcomes[0].message) << "a Join again gets the same Welcome again";
}

TEST(AdmissionRules, WhoDoesNotFitTheSessionIsRefused) {
  struct Row {
    std::string name;
    void (*change)(wire::Join&);
    std::string reason;
  };
  const std::vector<Row> rows{
      {"physics", [](wire::Join& j) { j.fingerprint = 1; }, "physics differs"},
      {"scene", [](wire::Join& j) { j.scene_hash = 1; }, "scenario differs"},
      {"authority", [](wire::Join& j) { j.authority = false; }, "authority rule differs"},
  };
  for (const Row& r : rows) {
    Situation s(4, 0);
    s.empty(2);
    wire::Join j = join(5);
    r.change(j);
    ListedCommands out;
    Admissions(s.session).on_join(joiner(1), j, s.view(), kLocal, out);
    const auto refusals = out.all<wire::Refuse>();
    ASSERT_EQ(refusals.size(), 1U) << r.name;
    EXPECT_EQ(refusals[0].message.reason.rfind(r.reason, 0), 0U) << refusals[0].message.reason;
  }
}

/// So many joiners in a session of twelve slots with one member.
class Admitting : public testing::Test {
 protected:
  Admitting() {
    for (PeerId p = 1; p < 12; ++p) s_.empty(p);
  }
  wire::Welcome welcome(int n) { return welcome(n, static_cast<std::uint64_t>(n), kLocal); }
  wire::Welcome welcome(int n, std::uint64_t nonce, Micros local) {
    ListedCommands out;
    rules_.on_join(joiner(n), join(nonce), s_.view(), local, out);
    return out.all<wire::Welcome>().at(0).message;
  }
  std::size_t pieces(int n, std::uint64_t cookie, Micros local) {
    return pieces(n, static_cast<std::uint64_t>(n), cookie, local);
  }
  std::size_t pieces(int n, std::uint64_t nonce, std::uint64_t cookie, Micros local) {
    ListedCommands out;
    const auto world = [this] {
      sync::Transfer t;
      t.have.resize(12);
      t.have[1] = has_of_1_;
      t.slots.resize(12);
      for (std::uint32_t i = 0; i < tail_; ++i) {
        t.tail.emplace_back().index = i;
        t.tail.back().tick = static_cast<Tick>(i);
        t.tail.back().avatar.emplace();
      }
      return t;
    };
    rules_.on_pull(joiner(n), {nonce, 0, ~std::uint64_t{0}, cookie}, world, local, out);
    return out.all<wire::Piece>().size();
  }

  Situation s_{12, 0};
  Admissions rules_{s_.session};
  std::uint32_t tail_ = 0;      ///< updates in the transfer
  std::uint32_t has_of_1_ = 0;  ///< updates of slot 1 that the joiner has with it
};

TEST_F(Admitting, OnlyWhoHasGotTheCookieIsSentTheWorld) {
  const wire::Welcome w = welcome(1);
  EXPECT_EQ(pieces(1, w.cookie + 1, kLocal), 0U);
  EXPECT_GT(pieces(1, w.cookie, kLocal), 0U);
}

TEST_F(Admitting, WhoDoesNotProveItsAddressIsForgottenSooner) {
  const wire::Welcome w = welcome(1);
  welcome(2);
  pieces(1, w.cookie, kLocal);
  rules_.advance(kLocal + Admissions::kUnproven + 1);
  EXPECT_EQ(rules_.guests(), 1U);
}

TEST_F(Admitting, ACrowdTakesTurns) {
  std::vector<std::uint64_t> cookies;
  for (int n = 1; n <= 6; ++n) cookies.push_back(welcome(n).cookie);
  std::ptrdiff_t served = 0;
  for (int n = 1; n <= 6; ++n) served += pieces(n, cookies[static_cast<std::size_t>(n - 1)], kLocal) > 0 ? 1 : 0;
  EXPECT_EQ(served, Admissions::kAtOnce);
  EXPECT_EQ(pieces(5, cookies[4], kLocal + Admissions::kTurn - 1), 0U);
  EXPECT_GT(pieces(5, cookies[4], kLocal + Admissions::kTurn), 0U) << "who takes long does not keep others waiting";
}

// Once, whoever asked again and again could have the coordinator send as much as its link carries.
TEST_F(Admitting, WhoBeginsAnewIsNotSentMoreForThat) {
  std::size_t sent = 0;
  std::size_t whole = 0;
  for (std::uint64_t nonce = 1; nonce <= 50; ++nonce) {
    const Micros local = kLocal + static_cast<Micros>(nonce) * 100'000;
    const wire::Welcome w = welcome(1, nonce, local);
    for (int again = 0; again < 20; ++again) sent += pieces(1, nonce, w.cookie, local);
    if (nonce == 1) whole = sent / Admissions::kMostTimes;
    rules_.advance(local);
  }
  EXPECT_GT(whole, 0U);
  EXPECT_EQ(sent, Admissions::kMostTimes * whole);
  const Micros later = kLocal + 60 * kMicrosPerSecond;
  rules_.advance(later);
  EXPECT_EQ(pieces(1, 60, welcome(1, 60, later).cookie, later), whole) << "it is another occasion";
}

// Once, what it had been sent of a long transfer used up what it might be sent of a short one, and it waited for 8 s.
TEST_F(Admitting, WhoBeginsAnewWithAShorterTransferGetsIt) {
  tail_ = 500;
  const wire::Welcome first = welcome(1, 1, kLocal);
  const std::size_t many = pieces(1, 1, first.cookie, kLocal);
  tail_ = 0;
  const wire::Welcome second = welcome(1, 2, kLocal + 1'000'000);
  const std::size_t few = pieces(1, 2, second.cookie, kLocal + 1'000'000);
  EXPECT_GT(many, Admissions::kMostTimes);
  EXPECT_EQ(few, 1U);
}

TEST_F(Admitting, ComesInByAnOrderOnceItHasTheWorld) {
  const wire::Welcome w = welcome(1);
  ListedCommands early;
  rules_.on_enter(joiner(1), {1}, s_.view(), true, early);
  EXPECT_TRUE(early.orders.empty()) << "it has not got the world";
  pieces(1, w.cookie, kLocal);
  ListedCommands held_up;
  rules_.on_enter(joiner(1), {1}, s_.view(), false, held_up);
  EXPECT_TRUE(held_up.orders.empty()) << "an eviction is under way";
  ListedCommands out;
  rules_.on_enter(joiner(1), {1}, s_.view(), true, out);
  ASSERT_EQ(out.orders.size(), 1U);
  ASSERT_TRUE(out.orders[0].admission);
  EXPECT_EQ(out.orders[0].admission->slot, w.peer);
  EXPECT_EQ(out.orders[0].admission->incarnation, w.incarnation);
  EXPECT_EQ(out.orders[0].admission->at, joiner(1));
  ListedCommands again;
  rules_.on_enter(joiner(1), {1}, s_.view(), true, again);
  EXPECT_TRUE(again.orders.empty()) << "once";
}

// The joiner has got them with its transfer, and nothing is to be passed on.
TEST_F(Admitting, WaitsForTheLastUpdateOfTheSlotsFormerOccupant) {
  const Tick ahead = s_.roster.now + 30;
  s_.log.begin(1, 0, kNow);
  s_.tells(1, 0, ahead);
  s_.log.close(1, 1);
  has_of_1_ = 1;
  pieces(1, welcome(1).cookie, kLocal);
  for (; s_.roster.now <= ahead; ++s_.roster.now) {
    ListedCommands early;
    rules_.on_enter(joiner(1), {1}, s_.view(), true, early);
    ASSERT_TRUE(early.orders.empty()) << s_.roster.now;
  }
  ListedCommands out;
  rules_.on_enter(joiner(1), {1}, s_.view(), true, out);
  ASSERT_EQ(out.orders.size(), 1U);
  EXPECT_EQ(out.orders[0].admission->slot, 1);
}

// Once, a coordinator passed on what one that had left had published with a clock that was ahead; all others took that
// for invalid, and cut the coordinator off.
TEST_F(Admitting, WaitsUntilWhatHasToBePassedOnIsNoLaterThanTheOrder) {
  pieces(1, welcome(1).cookie, kLocal);
  const Tick ahead = s_.roster.now + 30;
  s_.log.begin(2, 0, kNow);
  s_.tells(2, 0, ahead);
  s_.roster.seats[2].presence = node::Presence::kLeft;
  s_.log.close(2, 1);
  for (; s_.roster.now <= ahead; ++s_.roster.now) {
    ListedCommands early;
    rules_.on_enter(joiner(1), {1}, s_.view(), true, early);
    ASSERT_TRUE(early.orders.empty()) << s_.roster.now;
  }
  ListedCommands out;
  rules_.on_enter(joiner(1), {1}, s_.view(), true, out);
  ASSERT_EQ(out.orders.size(), 2U);
  EXPECT_EQ(out.orders[0].passed_on.at(0).tick, ahead);
  EXPECT_TRUE(out.orders[1].admission);
}

TEST_F(Admitting, BeginsAnewIfItsSlotIsTakenMeanwhile) {
  const wire::Welcome w = welcome(1);
  pieces(1, w.cookie, kLocal);
  s_.roster.seats[w.peer].incarnation = w.incarnation;
  ListedCommands out;
  rules_.on_enter(joiner(1), {1}, s_.view(), true, out);
  EXPECT_TRUE(out.orders.empty());
  EXPECT_EQ(rules_.guests(), 0U);
}

}  // namespace
}  // namespace padr::test
