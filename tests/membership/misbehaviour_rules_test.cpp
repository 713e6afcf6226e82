// Who may give which order, and who is cut off, as tables.
#include "common/membership/evictions.h"
#include "common/membership/misbehaviour_policy.h"
#include "common/wire/signature.h"
#include "tests/membership/rules.h"

namespace padr::test {
namespace {

using node::Evictions;
using node::MisbehaviourPolicy;
using sync::DropReason;

sync::Bundle by(PeerId p) {
  sync::Bundle b;
  b.peer = p;
  b.tick = kNow - 1;
  return b;
}

/// Slot 4 is free.
sync::Bundle admits(PeerId p, PeerId slot = 4, std::uint32_t incarnation = 50) {
  sync::Bundle b = by(p);
  b.admission.emplace();
  b.admission->slot = slot;
  b.admission->incarnation = incarnation;
  return b;
}

sync::Bundle removes(PeerId p, PeerId slot) {
  sync::Bundle b = by(p);
  b.removals.push_back({slot, 1U + slot, 0});
  return b;
}

sync::Bundle passes_on(PeerId p, PeerId slot) {
  sync::Bundle b = by(p);
  b.passed_on.push_back(by(slot));
  return b;
}

TEST(MisbehaviourRules, WhoMayGiveWhichOrder) {
  struct Row {
    std::string name;
    sync::Bundle order;
    void (*change)(Situation&, Evictions&);
    bool lawful;
  };
  const auto nothing = [](Situation&, Evictions&) {};
  const auto lost_coordinator = [](Situation& s, Evictions&) { s.silence(0, kLongAgo); };
  const auto replied_about_3 = [](Situation& s, Evictions& e) {
    ListedCommands out;
    e.on_poll(0, {{s.named(3)}, true, 0}, s.view(), kNow, false, out);
  };
  const auto replied_about_3_and_froze = [](Situation& s, Evictions&) { s.roster.seats[3].frozen = true; };
  // Peer 2 judges.
  const std::vector<Row> rows{
      {"no order", by(1), nothing, true},
      {"the coordinator admits", admits(0), nothing, true},
      {"it admits to the slot of somebody who is here", admits(0, 3), nothing, false},
      {"it admits to this peer's slot", admits(0, 2), nothing, false},
      {"it admits to the slot of somebody whose eviction is under way", admits(0, 3), replied_about_3_and_froze, true},
      {"it admits to the slot of somebody who is convicted", admits(0, 3),
       [](Situation& s, Evictions&) { s.roster.give_up(3, true); }, true},
      {"it admits with the highest number that is let pass", admits(0, 4, 4 + node::kMostIncarnationStep), nothing,
       true},
      {"it admits with a higher one", admits(0, 4, 5 + node::kMostIncarnationStep), nothing, false},
      {"somebody else admits", admits(1), nothing, false},
      {"the next admits, as the most senior is silent", admits(1), lost_coordinator, true},
      {"the most senior admits, with a newcomer in a lower slot", admits(1),
       [](Situation& s, Evictions&) { s.roster.seats[0].incarnation = 9; }, true},
      {"that newcomer admits", admits(0), [](Situation& s, Evictions&) { s.roster.seats[0].incarnation = 9; }, false},
      {"the coordinator makes its peer senior to others", admits(0, 4, 4), nothing, false},
      {"which have come just now, by the order of another coordinator", admits(0, 4, 4),
       [](Situation& s, Evictions&) { s.roster.seats[3].since = kNow - 20; }, true},
      {"of whom this peer has learned just now, as another coordinator lied", admits(0, 4, 4),
       [](Situation& s, Evictions&) { s.roster.seats[3].seated = kNow - 20; }, true},
      {"one more junior than this peer admits", admits(3), lost_coordinator, false},
      {"the coordinator removes whom this peer was asked about", removes(0, 3), replied_about_3, true},
      {"it removes somebody else", removes(0, 1), replied_about_3, false},
      {"it removes without asking", removes(0, 3), nothing, false},
      {"somebody else removes whom the coordinator asked about", removes(1, 3), replied_about_3, false},
      {"the coordinator passes on what somebody who lives has not told here", passes_on(0, 3), nothing, false},
      {"the coordinator passes on an update of whom it asked about", passes_on(0, 3), replied_about_3, true},
      {"it passes on what is here", passes_on(1, 3), [](Situation& s, Evictions&) { s.tells(3, 0, kNow - 1); }, true},
      {"it passes on an update of who has gone", passes_on(0, 3),
       [](Situation& s, Evictions&) { s.roster.seats[3].presence = node::Presence::kAbsent; }, true},
      {"of before this peer joined", admits(1), [](Situation& s, Evictions&) { s.roster.in_since = kNow; }, true},
      {"this peer only watches", admits(1), [](Situation& s, Evictions&) { s.roster.member = false; }, true},
  };
  for (const Row& r : rows) {
    Situation s(5, 2);
    s.empty(4);
    s.roster.seats[4].incarnation = 0;
    Evictions evictions(s.session);
    r.change(s, evictions);
    sync::StatePacket packet;
    packet.updates.push_back(r.order);
    const DropReason why = MisbehaviourPolicy(s.session).judge(packet, kNoPeer, s.view(), evictions);
    EXPECT_EQ(why, r.lawful ? DropReason::kNone : DropReason::kRight) << r.name;
  }
}

// What a rule allows depends on who has heard what. If members that judge differently did not take each other's word, a
// lying coordinator could leave them with rosters that differ, and the orders of the next one would be refused.
TEST(MisbehaviourRules, AnOrderThatAnotherMemberHasTakenIsTaken) {
  struct Row {
    std::string name;
    bool sealed;
    PeerId relayed_by;
    Tick relayer_since;
    bool is_signed;
    DropReason why;
    Tick in_since = 0;
    PeerId admitted_by = kNoPeer;
  };
  const std::vector<Row> rows{
      {"its own peer sends it", true, kNoPeer, 0, true, DropReason::kRight},
      {"another member relays it", true, 3, 0, true, DropReason::kNone},
      {"which was not in yet when it was given", true, 3, kNow, true, DropReason::kRight},
      {"its own peer relays it", true, 0, 0, true, DropReason::kRight},
      {"another member relays what was never signed", true, 3, 0, false, DropReason::kSignature},
      {"of before this peer joined", true, kNoPeer, 0, true, DropReason::kRight, kNow},
      {"of before this peer joined, by the peer that let it in", true, kNoPeer, 0, true, DropReason::kNone, kNow, 0},
      {"of before this peer joined, relayed by a member of that time", true, 3, 0, true, DropReason::kNone, kNow},
      {"anybody may have said so without a key", false, 3, 0, true, DropReason::kRight},
  };
  for (const Row& r : rows) {
    Situation s(5, 2);
    s.session.config.sealed = r.sealed;
    wire::Key secret{};
    secret.fill(5);
    s.roster.seats[0].at.key = wire::public_key(secret);
    s.roster.seats[3].since = r.relayer_since;
    s.roster.in_since = r.in_since;
    s.roster.admitted_by = r.admitted_by;
    sync::StatePacket packet;
    packet.updates.push_back(removes(0, 1));
    if (r.is_signed)
      packet.updates[0].signature = wire::sign_update(
          wire::signing_key(secret), {s.roster.session, s.roster.seats[0].incarnation}, packet.updates[0]);
    const DropReason why = MisbehaviourPolicy(s.session).judge(packet, r.relayed_by, s.view(), Evictions(s.session));
    EXPECT_EQ(why, r.why) << r.name;
  }
}

// Its admission may be here, and wait for an earlier order. Once, a joiner took what a liar made up in its name, and
// cut off the newcomer, whose own update of that tick it did not take.
TEST(MisbehaviourRules, NothingIsPassedOnOfWhoseKeyIsNotKnownYet) {
  struct Row {
    const char* name;
    std::uint32_t first;  ///< of who sits in the slot
    bool has_key;         ///< who sits there
    bool waits;           ///< the newcomer's admission
    bool is_signed;       ///< by the newcomer
    DropReason why;
  };
  const Row rows[] = {
      {"nobody has sat there yet", 0, false, false, false, DropReason::kRight},
      {"whoever sits there has not signed it", 0, true, false, true, DropReason::kRight},
      {"of a former one, of before this peer joined", 9, true, false, false, DropReason::kNone},
      {"of a newcomer whose admission waits", 0, false, true, true, DropReason::kNone},
      {"which it has not signed", 0, false, true, false, DropReason::kRight},
      {"of a newcomer in a slot that another one had", 0, true, true, true, DropReason::kNone},
  };
  wire::Key secret{};
  secret.fill(5);
  wire::Key newcomers{};
  newcomers.fill(6);
  const std::uint32_t kNew = 50;
  for (const Row& r : rows) {
    Situation s(5, 2);
    s.session.config.sealed = true;
    s.roster.seats[0].at.key = wire::public_key(secret);
    s.empty(4);
    s.roster.seats[4].first = r.first;
    s.roster.seats[4].at.key = r.has_key ? wire::public_key(secret) : PublicKey{};
    s.roster.in_since = kNow;
    s.roster.admitted_by = 0;
    sync::Bundle admission = admits(0, 4, kNew);
    admission.index = 5;
    admission.tick = kNow + 1;
    admission.admission->at.key = wire::public_key(newcomers);
    ASSERT_TRUE(!r.waits || s.log.insert(admission));
    sync::Bundle order = by(0);
    order.passed_on.push_back(by(4));
    if (r.is_signed)
      order.passed_on[0].signature =
          wire::sign_update(wire::signing_key(newcomers), {s.roster.session, kNew}, order.passed_on[0]);
    order.signature =
        wire::sign_update(wire::signing_key(secret), {s.roster.session, s.roster.seats[0].incarnation}, order);
    sync::StatePacket packet;
    packet.updates.push_back(order);
    EXPECT_EQ(MisbehaviourPolicy(s.session).judge(packet, kNoPeer, s.view(), Evictions(s.session)), r.why) << r.name;
  }
}

// Each has a valid signature, so that it has to be checked; none can be filed.
TEST(MisbehaviourRules, SignaturesAreCheckedInMeasure) {
  Situation s(4, 2);
  s.session.config.sealed = true;
  wire::Key secret{};
  secret.fill(5);
  s.roster.seats[1].at.key = wire::public_key(secret);
  const auto says = [&](std::uint32_t index) {
    sync::Bundle b = by(1);
    b.index = index;
    b.signature = wire::sign_update(wire::signing_key(secret), {s.roster.session, s.roster.seats[1].incarnation}, b);
    sync::StatePacket packet;
    packet.updates.push_back(b);
    return packet;
  };
  const Evictions evictions(s.session);
  MisbehaviourPolicy rules(s.session);
  const auto judge = [&](std::uint32_t index) { return rules.judge(says(index), kNoPeer, s.view(), evictions); };
  EXPECT_EQ(judge(sync::UpdateLog::kMostBeyond), DropReason::kNone);
  EXPECT_EQ(judge(sync::UpdateLog::kMostBeyond + 1), DropReason::kOrder) << "no log would take it";
  int checked = 1;
  while (judge(1) == DropReason::kNone && checked < 10'000) ++checked;
  EXPECT_EQ(checked, static_cast<int>(MisbehaviourPolicy::kMostChecks));
  EXPECT_EQ(judge(1), DropReason::kCutOff);
  EXPECT_TRUE(rules.hears(1, s.view())) << "it is not held against anybody";
  s.roster.now += 10;
  checked = 0;
  while (judge(1) == DropReason::kNone && checked < 10'000) ++checked;
  EXPECT_EQ(checked, static_cast<int>(10 * MisbehaviourPolicy::kChecksPerTick));
  // What others show of a lost peer is counted apart from what they say themselves, and for each of them.
  for (const PeerId by : {PeerId{0}, PeerId{1}}) {
    int shown = 0;
    while (rules.said(by, says(1).updates[0], s.view()) && shown < 10'000) ++shown;
    EXPECT_EQ(shown, static_cast<int>(MisbehaviourPolicy::kMostChecks));
  }
}

TEST(MisbehaviourRules, OnlyWithAKeyIsNonsensePunished) {
  for (const bool sealed : {false, true}) {
    Situation s(4, 0);
    s.session.config.sealed = sealed;
    s.roster.seats[2].at.key.fill(9);
    MisbehaviourPolicy rules(s.session);
    ListedCommands out;
    const auto drop = [&](DropReason why) { rules.on_drop(2, why, s.view(), 0, out); };
    for (int i = 0; i < 1000; ++i) {
      drop(DropReason::kDuplicate);
      drop(DropReason::kForeign);
    }
    EXPECT_TRUE(out.cut_offs.empty()) << "late and doubled datagrams are nobody's fault";
    for (std::size_t i = 0; i + 1 < MisbehaviourPolicy::kNonsense; ++i) drop(DropReason::kMalformed);
    EXPECT_TRUE(out.cut_offs.empty());
    drop(DropReason::kMalformed);
    EXPECT_EQ(out.cut_offs.size(), sealed ? 1U : 0U);
    EXPECT_EQ(rules.hears(2, s.view()), !sealed);
    EXPECT_EQ(rules.bars(s.roster.seats[2].at.key, s.view()), sealed);
  }
}

TEST(MisbehaviourRules, WhoHoldsUpEverybodyIsCutOff) {
  struct Row {
    std::string name;
    PeerId self;
    void (*change)(Situation&);
    std::vector<PeerId> cut_offs;
  };
  constexpr Tick kOwed = kNow - node::View::kArrears;
  constexpr Tick kIgnored = kNow - MisbehaviourPolicy::kPatience;
  const std::vector<Row> rows{
      {"all tell and acknowledge", 0, [](Situation&) {}, {}},
      {"one does not tell", 0, [](Situation& s) { s.log.begin(2, 0, kOwed); }, {2}},
      {"a tick short", 0, [](Situation& s) { s.log.begin(2, 0, kOwed + 1); }, {}},
      {"one does not acknowledge", 0, [](Situation& s) { s.roster.seats[2].unacknowledged = kIgnored; }, {2}},
      {"a tick short of that", 0, [](Situation& s) { s.roster.seats[2].unacknowledged = kIgnored + 1; }, {}},
      {"something was in the way",
       0,
       [](Situation& s) {
         s.roster.seats[2].unacknowledged = kIgnored;
         s.roster.seats[2].acks_forgiven = kIgnored + 1;
       },
       {}},
      {"nor did it while it asks to be let in anew",
       0,
       [](Situation& s) {
         s.returning = only(2);
         s.roster.seats[2].unacknowledged = kIgnored;
       },
       {}},
      {"for too long",
       0,
       [](Situation& s) {
         s.roster.now = 2 * MisbehaviourPolicy::kMostPatience;
         for (PeerId p = 1; p < 4; ++p) s.log.mark(p, s.roster.now, 0);
         s.returning = only(2);
         s.roster.seats[2].unacknowledged = s.roster.now - MisbehaviourPolicy::kMostPatience;
         for (node::Seat& seat : s.roster.seats) seat.heard = seat.answered = s.roster.now;
       },
       {2}},
      {"updates of a former peer in the slot are missing",
       0,
       [](Situation& s) {
         s.log.begin(2, 5, kOwed);
         s.roster.seats[2].first = 6;
       },
       {}},
      {"it is excused",
       0,
       [](Situation& s) {
         s.log.begin(2, 0, kOwed);
         s.roster.seats[2].excused = kNow - 1;
       },
       {}},
      {"it is not heard: that is silence",
       0,
       [](Situation& s) {
         s.log.begin(2, 0, kOwed);
         s.silence(2, kNow - kTicksPerSecond - 1);
       },
       {}},
      {"another peer coordinates", 1, [](Situation& s) { s.log.begin(2, 0, kOwed); }, {2}},
      {"the coordinator does not tell", 1, [](Situation& s) { s.log.begin(0, 0, kOwed); }, {0}},
      {"this peer leaves",
       0,
       [](Situation& s) {
         s.log.begin(2, 0, kOwed);
         s.roster.leaving = true;
       },
       {}},
  };
  for (const Row& r : rows) {
    Situation s(4, r.self);
    r.change(s);
    ListedCommands out;
    MisbehaviourPolicy(s.session).advance(s.view(), out);
    EXPECT_EQ(out.cut_offs, r.cut_offs) << r.name;
  }
}

// Once, an honest coordinator was cut off: its orders rested on one of a peer that had left while this one was out of
// reach. With a key the others send that one.
TEST(MisbehaviourRules, WithoutAKeyWhoseOrdersMayBeLawfulByWhatIsNotHereIsNotCutOff) {
  constexpr Tick kOwed = kNow - node::View::kArrears;
  struct Row {
    const char* name;
    sync::DropReason dropped;
    Tick lacking;  ///< of peer 3, which is silent
    bool cut_off;
  };
  const Row rows[] = {
      {"peer 3 has told less", sync::DropReason::kRight, kOwed, false},
      {"peer 3 has told more", sync::DropReason::kRight, kOwed + 1, true},
      {"what was dropped was no order", sync::DropReason::kOrder, kOwed, true},
  };
  for (const Row& r : rows) {
    Situation s(4, 0);
    MisbehaviourPolicy rules(s.session);
    ListedCommands out;
    s.log.begin(2, 0, kOwed);
    s.log.begin(3, 0, r.lacking);
    s.silence(3, kNow - kTicksPerSecond - 1);
    rules.on_drop(2, r.dropped, s.view(), 0, out);
    rules.advance(s.view(), out);
    EXPECT_EQ(out.cut_offs, r.cut_off ? std::vector<PeerId>{2} : std::vector<PeerId>{}) << r.name;
  }
}

// Once, all waited for 8 s for a coordinator whose order nobody took.
TEST(MisbehaviourRules, WhoseNextUpdateIsRefusedIsCutOffSooner) {
  struct Row {
    const char* name;
    std::uint32_t index;  ///< of the order that is refused
    Tick owed;
    bool peer_3_is_silent;
    Tick ago;
    bool cut_off;
    bool sealed = true;
  };
  constexpr Tick kLong = MisbehaviourPolicy::kRefused;
  const Row rows[] = {
      {"nobody has relayed it", 7, kLong, false, 0, true},
      {"somebody may still relay it", 7, kLong - 1, false, 0, false},
      {"another one is missing", 8, kLong, false, 0, false},
      {"it is not said any more", 7, kLong, false, MisbehaviourPolicy::kUnlawful, false},
      {"without a key nobody's word counts but its own", 7, kLong, false, 0, false, false},
      {"what peer 3 has said somebody would have relayed, too", 7, kLong, true, 0, true},
  };
  for (const Row& r : rows) {
    Situation s(4, 1);
    s.session.config.sealed = r.sealed;
    MisbehaviourPolicy rules(s.session);
    Evictions evictions(s.session);
    ListedCommands out;
    const auto owe = [&] {
      s.log.begin(0, 7, s.roster.now - r.owed);
      s.log.begin(3, 0, r.peer_3_is_silent ? s.roster.now - r.owed : s.roster.now);
      s.silence(0, s.roster.now);
      s.silence(2, s.roster.now);
      s.silence(3, r.peer_3_is_silent ? s.roster.now - kTicksPerSecond - 1 : s.roster.now);
    };
    owe();
    sync::StatePacket packet;
    packet.updates.push_back(removes(0, 2));
    packet.updates[0].index = r.index;
    const auto why = rules.judge(packet, kNoPeer, s.view(), evictions);
    EXPECT_EQ(why, DropReason::kRight) << r.name;
    rules.on_drop(0, why, s.view(), 0, out);
    s.roster.now += r.ago;
    owe();
    rules.advance(s.view(), out);
    EXPECT_EQ(out.cut_offs, r.cut_off ? std::vector<PeerId>{0} : std::vector<PeerId>{}) << r.name;
  }
}

}  // namespace
}  // namespace padr::test
