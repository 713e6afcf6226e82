// By which way a member is reached: what was measured and told, and what follows.
#include "common/paths/paths.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace padr::test {
namespace {

using node::Paths;

constexpr Tick kStart = 1000;

/// Four members, of whom this one is 0; all links work and take two ticks.
struct Scene {
  node::Roster roster;
  std::vector<Paths::Link> links{4, {0, 2}};
  Paths paths;
  std::vector<Paths::Change> changes;
  std::vector<wire::Reach> told;
  PeerSet told_to = 0;
  PeerSet silent = 0;  ///< of whom nothing comes directly
  PeerSet mute = 0;    ///< of whom nothing comes

  Scene() {
    roster.self = 0;
    roster.member = true;
    roster.now = kStart;
    roster.seats.resize(4);
    for (PeerId p = 1; p < 4; ++p) roster.seats[p].presence = node::Presence::kThere;
    run(1);
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      ++roster.now;
      for (PeerId p = 1; p < 4; ++p) {
        if ((mute & only(p)) == 0) roster.seats[p].heard = roster.now;
        if (((silent | mute) & only(p)) == 0) paths.note_direct(p, roster.now);
      }
      for (const Paths::Change& c : paths.advance(roster, links)) changes.push_back(c);
      if (const auto t = paths.due(roster, links)) {
        told.push_back(t->reach);
        told_to = t->to;
      }
    }
  }
  void tell(PeerId from, std::vector<wire::Way> heard) {
    paths.on_reach(from, {roster.now, std::move(heard)}, roster.now);
  }
  /// Member 2 says so in every tick.
  void tell_for(int ticks, const std::vector<wire::Way>& heard) {
    for (int i = 0; i < ticks; ++i) {
      tell(2, heard);
      run(1);
    }
  }
  bool listed(PeerId p) const {
    return std::any_of(told.back().heard.begin(), told.back().heard.end(), [p](const auto& w) { return w.slot == p; });
  }
};

struct Row {
  std::string name;
  std::function<void(Scene&)> happens;
  PeerId carrier;  ///< of member 2, kNoPeer: none
};

TEST(PathsRules, WhoIsReachedThroughWhom) {
  const std::vector<Row> rows{
      {"all is well", [](Scene& s) { s.run(100); }, kNoPeer},
      {"it is not heard and does not answer",
       [](Scene& s) {
         s.silent = only(2);
         s.links[2].unanswered = Paths::kUnheard;
         s.run(Paths::kUnheard);
       },
       1},
      {"a tick short",
       [](Scene& s) {
         s.silent = only(2);
         s.links[2].unanswered = Paths::kUnheard;
         s.run(Paths::kUnheard - 1);
       },
       kNoPeer},
      {"it answers, though it is not heard directly",
       [](Scene& s) {
         s.silent = only(2);
         s.run(Paths::kUnheard);
       },
       kNoPeer},
      {"it is heard, and has said nothing of whom it hears",
       [](Scene& s) {
         s.links[2].unanswered = 500;
         s.run(1);
       },
       kNoPeer},
      {"this peer was held up meanwhile",
       [](Scene& s) {
         s.silent = only(2);
         s.links[2].unanswered = 500;
         s.run(Paths::kUnheard - 1);
         s.roster.seats[2].excused = s.roster.now;
         s.run(1);
       },
       kNoPeer},
      {"it does not answer, but has told that it hears this peer: the other direction is broken",
       [](Scene& s) {
         s.links[2].unanswered = 500;
         s.tell(2, {{0, 2}, {1, 2}, {3, 2}});
         s.run(1);
       },
       kNoPeer},
      {"it has told that it does not hear this peer",
       [](Scene& s) {
         s.tell(2, {{1, 2}, {3, 2}});
         s.run(1);
       },
       1},
      {"what it has told is old",
       [](Scene& s) {
         s.tell(2, {{1, 2}, {3, 2}});
         s.roster.now += Paths::kFresh;
         s.run(1);
       },
       kNoPeer},
      {"it does not hear the first of the others either",
       [](Scene& s) {
         s.tell(2, {{3, 2}});
         s.run(1);
       },
       3},
      {"it hears nobody",
       [](Scene& s) {
         s.tell(2, {});
         s.run(1);
       },
       kNoPeer},
      {"both of its carrier's links together are quicker",
       [](Scene& s) {
         s.links[1].delay = 1;
         s.tell(2, {{1, 12}, {3, 2}});
         s.run(1);
       },
       3},
      {"the carrier does not answer this peer",
       [](Scene& s) {
         s.links[1].unanswered = Paths::kUnheard;
         s.tell(2, {{1, 2}, {3, 2}});
         s.run(1);
       },
       3},
      {"the carrier is not heard by this peer",
       [](Scene& s) {
         s.silent = only(1);
         s.run(Paths::kUnheard + 1);
         s.tell(2, {{1, 2}, {3, 2}});
         s.run(1);
       },
       3},
      {"the carrier is not heard directly, but has told that it hears this peer",
       [](Scene& s) {
         s.silent = only(1);
         s.run(Paths::kUnheard + 1);
         s.tell(1, {{0, 2}, {2, 2}, {3, 2}});
         s.tell(2, {{1, 2}, {3, 2}});
         s.run(1);
       },
       1},
      {"the carrier has told that it does not hear this peer",
       [](Scene& s) {
         s.tell(1, {{2, 2}, {3, 2}});
         s.tell(2, {{1, 2}, {3, 2}});
         s.run(1);
       },
       3},
      {"it says that nothing comes by its carrier",
       [](Scene& s) {
         s.tell_for(Paths::kUnanswered + 1, {{1, 2}, {3, 2}});
       },
       3},
      {"a tick before",
       [](Scene& s) {
         s.tell_for(Paths::kUnanswered, {{1, 2}, {3, 2}});
       },
       1},
      {"it says that what is carried comes",
       [](Scene& s) {
         s.tell_for(500, {{0, 2, true}, {1, 2}, {3, 2}});
       },
       1},
      {"nothing comes by its carrier either: it may be its own that is of no use",
       [](Scene& s) {
         s.mute = only(2);
         s.links[2].unanswered = 500;
         s.run(Paths::kUnheard + 2 * Paths::kUnanswered - 1);
       },
       1},
      {"the same for longer",
       [](Scene& s) {
         s.mute = only(2);
         s.links[2].unanswered = 500;
         s.run(Paths::kUnheard + 2 * Paths::kUnanswered);
       },
       3},
      {"it does not answer by its carrier either, and nobody else hears it",
       [](Scene& s) {
         s.tell_for(2 * Paths::kUnanswered, {{1, 2}});
       },
       1},
      {"another carrier is a little quicker than the present one",
       [](Scene& s) {
         s.tell(2, {{1, 4}, {3, 8}});
         s.run(1);
         s.tell(2, {{1, 4}, {3, 2}});
         s.run(1);
       },
       1},
      {"another carrier is much quicker than the present one",
       [](Scene& s) {
         s.tell(2, {{1, 9}, {3, 20}});
         s.run(1);
         s.tell(2, {{1, 9}, {3, 2}});
         s.run(1);
       },
       3},
      {"it is heard again",
       [](Scene& s) {
         s.tell(2, {{1, 2}, {3, 2}});
         s.run(1);
         s.tell(2, {{0, 2}, {1, 2}, {3, 2}});
         s.run(1);
       },
       kNoPeer},
      {"it has left its slot to another one",
       [](Scene& s) {
         s.tell(2, {{1, 2}, {3, 2}});
         s.run(1);
         s.roster.seats[2].incarnation = 7;
         s.run(1);
       },
       kNoPeer},
  };
  for (const Row& row : rows) {
    Scene s;
    row.happens(s);
    EXPECT_EQ(s.paths.carrier(2), row.carrier) << row.name;
  }
}

// Once, whoever came into the slot of a carrier that had failed was passed over for that, for half an hour at last.
TEST(PathsRules, WhatACarrierFailedAtIsNotHeldAgainstWhoComesAfterIt) {
  for (const bool another : {false, true}) {
    Scene s;
    s.tell_for(Paths::kUnanswered + 1, {{1, 2}, {3, 20}});
    ASSERT_EQ(s.paths.carrier(2), 3);
    if (another) s.roster.seats[1].incarnation = 9;
    s.tell_for(2, {{0, 2, true}, {1, 2}, {3, 20}});
    EXPECT_EQ(s.paths.carrier(2), another ? 1 : 3);
  }
}

TEST(PathsRules, WhatIsToldAndWhen) {
  Scene s;
  s.run(200);
  EXPECT_TRUE(s.told.empty()) << "all is well";
  s.mute = only(2);
  s.run(Paths::kUnheard);
  ASSERT_EQ(s.told.size(), 1U) << "at once";
  EXPECT_FALSE(s.listed(2));
  EXPECT_EQ(s.told_to, only(2)) << "nobody else needs to know";
  EXPECT_TRUE(s.listed(1) && s.listed(3));
  s.run(10 * Paths::kTellAgain);
  EXPECT_EQ(s.told.size(), 11U) << "as long as it lasts";
  s.mute = 0;
  s.run(1);
  ASSERT_EQ(s.told.size(), 12U) << "that it is over, too";
  EXPECT_EQ(s.told_to, only(2));
  EXPECT_TRUE(s.listed(2));
  s.run(20 * Paths::kTellAgain);
  EXPECT_EQ(s.told.size(), 11U + Paths::kTellAfterwards);
}

// A link that passes one datagram in a hundred is not taken up again and again.
TEST(PathsRules, ADirectWayThatFailsAgainIsLeftAloneForLonger) {
  Scene s;
  std::vector<Tick> stayed;
  for (int i = 0; i < 4; ++i) {
    s.tell(2, {{1, 2}, {3, 2}});
    s.run(1);
    ASSERT_NE(s.paths.carrier(2), kNoPeer);
    const Tick since = s.roster.now;
    while (s.paths.carrier(2) != kNoPeer) {
      s.tell(2, {{0, 2}, {1, 2}, {3, 2}});
      s.run(1);
    }
    stayed.push_back(s.roster.now - since);
  }
  EXPECT_EQ(stayed, (std::vector<Tick>{1, Paths::kStay, 2 * Paths::kStay, 4 * Paths::kStay}));
}

TEST(PathsRules, ACarrierIsReportedOnceItsMemberAnswers) {
  Scene s;
  s.mute = only(2);
  for (int i = 0; i < 200; ++i) {
    ++s.links[2].unanswered;
    s.run(1);
  }
  EXPECT_NE(s.paths.carrier(2), kNoPeer);
  EXPECT_TRUE(s.changes.empty()) << "it may have ended";
  s.links[2].unanswered = 3;
  s.run(1);
  ASSERT_EQ(s.changes.size(), 1U);
  EXPECT_EQ(s.changes[0], (Paths::Change{2, 1}));
  s.tell(2, {{0, 2}, {1, 2}, {3, 2}});
  s.run(1);
  ASSERT_EQ(s.changes.size(), 2U);
  EXPECT_EQ(s.changes[1], (Paths::Change{2, kNoPeer}));
}

TEST(PathsRules, WhoseCarrierHasLeftIsNotReachedDirectlyForThat) {
  Scene s;
  s.silent = only(2);
  s.tell_for(Paths::kUnheard + Paths::kReported + 1, {{1, 2}, {3, 2, true}});
  ASSERT_EQ(s.changes, (std::vector<Paths::Change>{{2, 1}}));
  s.roster.seats[1].presence = s.roster.seats[3].presence = node::Presence::kAbsent;
  for (Tick i = 0; i < 2 * Paths::kFresh; ++i) {
    ++s.links[2].unanswered;
    s.run(1);
    ASSERT_EQ(s.paths.carrier(2), kNoPeer);
  }
  EXPECT_EQ(s.changes.size(), 1U);
  s.silent = 0;
  s.links[2].unanswered = 0;
  s.tell(2, {{0, 2}});
  s.run(1);
  EXPECT_EQ(s.changes.back(), (Paths::Change{2, kNoPeer}));
}

// Both had been held up at once, as on a busy machine: each said that it heard the other directly.
TEST(PathsRules, WhoIsCarriedIsNotHeardDirectlyAfterThisPeerWasHeldUp) {
  Scene s;
  s.silent = only(2);
  s.tell_for(Paths::kUnheard + Paths::kReported + 1, {{1, 2}, {3, 2, true}});
  ASSERT_EQ(s.paths.carrier(2), 1);
  for (PeerId p = 1; p < 4; ++p) s.roster.seats[p].excused = s.roster.now;
  for (Tick i = 0; i < Paths::kUnheard; ++i) {
    s.tell_for(1, {{1, 2}, {3, 2, true}});
    for (const wire::Way& w : s.told.back().heard) EXPECT_TRUE(w.slot != 2 || w.carried) << i;
  }
}

TEST(PathsRules, WhatComesLateIsIgnored) {
  Scene s;
  s.paths.on_reach(2, {500, {{0, 2}, {1, 2}, {3, 2}}}, s.roster.now);
  s.paths.on_reach(2, {499, {{1, 2}, {3, 2}}}, s.roster.now);
  s.run(1);
  EXPECT_EQ(s.paths.carrier(2), kNoPeer);
}

// Where a member says that it is: only what another machine may send to counts, and the last word.
TEST(PathsRules, OwnAddressesAreThoseOfOneHost) {
  const auto v6 = [](std::uint8_t first, std::uint8_t second) {
    Endpoint e;
    e.address[0] = first;
    e.address[1] = second;
    e.address[15] = 2;
    e.port = 7;
    return e;
  };
  Endpoint loopback;
  loopback.address[15] = 1;
  loopback.port = 7;
  const std::vector<Endpoint> good{ipv4({192, 168, 0, 2}, 7),
                                   ipv4({10, 0, 0, 2}, 7),
                                   ipv4({198, 51, 100, 2}, 7),
                                   ipv4({169, 253, 0, 2}, 7),
                                   ipv4({223, 0, 0, 2}, 7),
                                   v6(0x20, 0x01),
                                   v6(0xFD, 0),
                                   v6(0xFE, 0xC0)};
  const std::vector<Endpoint> wrong{ipv4({127, 0, 0, 1}, 7),
                                    ipv4({0, 0, 0, 1}, 7),
                                    ipv4({169, 254, 0, 2}, 7),
                                    ipv4({224, 0, 0, 1}, 7),
                                    ipv4({255, 255, 255, 255}, 7),
                                    ipv4({10, 0, 0, 2}, 0),
                                    loopback,
                                    v6(0xFE, 0x80),
                                    v6(0xFE, 0xBF),
                                    v6(0xFF, 0x02)};
  Scene s;
  for (const Endpoint& e : good) {
    s.run(1);
    s.paths.on_reach(2, {s.roster.now, {}, {e}}, s.roster.now);
    EXPECT_EQ(s.paths.addresses(2), std::vector{e}) << to_string(e);
  }
  for (const Endpoint& e : wrong) {
    s.run(1);
    s.paths.on_reach(2, {s.roster.now, {}, {e, good[0]}}, s.roster.now);
    EXPECT_EQ(s.paths.addresses(2), std::vector{good[0]}) << to_string(e);
  }
  s.paths.on_reach(2, {s.roster.now - 1, {}, {good[1]}}, s.roster.now);
  EXPECT_EQ(s.paths.addresses(2), std::vector{good[0]}) << "an older word";
  s.paths.note_seen(2, good[1]);
  EXPECT_EQ(s.paths.addresses(2), (std::vector{good[0], good[1]}));
  for (const Endpoint& e : wrong) s.paths.note_seen(2, e);
  s.paths.note_seen(2, good[2]);
  EXPECT_EQ(s.paths.addresses(2), (std::vector{good[0], good[2]})) << "the last place counts";
  s.roster.seats[2].incarnation = 5;
  s.run(1);
  EXPECT_TRUE(s.paths.addresses(2).empty()) << "somebody else sits there";
}

}  // namespace
}  // namespace padr::test
