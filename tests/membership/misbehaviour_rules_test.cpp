// Who may give which order, and who is cut off, as tables.
#include "common/membership/evictions.h"
#include "common/membership/misbehaviour_policy.h"
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

sync::Bundle admits(PeerId p) {
  sync::Bundle b = by(p);
  b.admission.emplace();
  b.admission->slot = 3;
  b.admission->incarnation = 50;
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
    e.on_poll(0, {{s.named(3)}, true, 0}, s.view(), kNow, out);
  };
  // Peer 2 judges.
  const std::vector<Row> rows{
      {"no order", by(1), nothing, true},
      {"the coordinator admits", admits(0), nothing, true},
      {"somebody else admits", admits(1), nothing, false},
      {"the next admits, as the lowest is silent", admits(1), lost_coordinator, true},
      {"the next admits, as the lowest is new", admits(1),
       [](Situation& s, Evictions&) { s.roster.seats[0].since = kNow - 20; }, true},
      {"one above this peer admits", admits(3), lost_coordinator, false},
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
    Situation s(4, 2);
    Evictions evictions(s.session);
    r.change(s, evictions);
    sync::StatePacket packet;
    packet.updates.push_back(r.order);
    const DropReason why = MisbehaviourPolicy(s.session).judge(packet, s.view(), evictions);
    EXPECT_EQ(why, r.lawful ? DropReason::kNone : DropReason::kRight) << r.name;
  }
}

TEST(MisbehaviourRules, OnlyWithAKeyIsNonsensePunished) {
  for (const bool sealed : {false, true}) {
    Situation s(4, 0);
    s.session.config.sealed = sealed;
    s.roster.seats[2].at.key.fill(9);
    const Evictions evictions(s.session);
    MisbehaviourPolicy rules(s.session);
    ListedCommands out;
    const auto drop = [&](DropReason why) { rules.on_drop(2, why, s.view(), evictions, 0, out); };
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
    std::vector<std::pair<PeerId, bool>> cut_offs;
  };
  constexpr Tick kOwed = kNow - MisbehaviourPolicy::kArrears;
  const std::vector<Row> rows{
      {"all tell and acknowledge", 0, [](Situation&) {}, {}},
      {"one does not tell", 0, [](Situation& s) { s.log.begin(2, 0, kOwed); }, {{2, true}}},
      {"a tick short", 0, [](Situation& s) { s.log.begin(2, 0, kOwed + 1); }, {}},
      {"one does not acknowledge", 0, [](Situation& s) { s.roster.seats[2].unacknowledged = kOwed; }, {{2, true}}},
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
      {"another peer coordinates", 1, [](Situation& s) { s.log.begin(2, 0, kOwed); }, {}},
      {"the coordinator does not tell", 1, [](Situation& s) { s.log.begin(0, 0, kOwed); }, {{0, true}}},
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
    MisbehaviourPolicy(s.session).advance(s.view(), Evictions(s.session), out);
    EXPECT_EQ(out.cut_offs, r.cut_offs) << r.name;
  }
}

}  // namespace
}  // namespace padr::test
