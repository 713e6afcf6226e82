// Two updates that one peer has signed, and what they prove: as tables.
#include "common/membership/testimony.h"

#include "common/wire/signature.h"
#include "tests/membership/rules.h"

namespace padr::test {
namespace {

using node::Testimony;
using Proof = sync::Transfer::Proof;

const SessionId kSession{1, 2, 3};

wire::Key secret(std::uint8_t n) {
  wire::Key k{};
  k.fill(n);
  return k;
}

sync::Bundle update(std::uint32_t index, Tick tick, float x = 0, PeerId peer = 2) {
  sync::Bundle b;
  b.peer = peer;
  b.index = index;
  b.tick = tick;
  b.avatar.emplace();
  b.avatar->position.x = x;
  return b;
}

/// Member 1 sees what others send of peer 2, whose incarnation is 3.
class Told : public testing::Test {
 protected:
  Told() {
    s_.session.config.sealed = true;
    s_.session.id = s_.roster.session = kSession;
    for (PeerId p = 0; p < 4; ++p) s_.roster.seats[p].at.key = wire::public_key(secret(1U + p));
    s_.log.begin(2, 10, kNow - 100);
  }
  sync::Bundle said(sync::Bundle b, std::uint32_t incarnation = 3) const {
    b.signature = wire::sign_update(wire::signing_key(secret(1U + b.peer)), {kSession, incarnation}, b);
    return b;
  }
  bool convicted() const { return rules_.convicts(s_.roster.seats[2].at.key); }
  void from(PeerId p, const sync::Bundle& b, std::uint32_t incarnation = 3) {
    rules_.on_updates(p, {2, incarnation, {b}}, s_.view());
  }

  Situation s_{4, 1};
  Testimony rules_{s_.session};
};

TEST(Contradiction, Table) {
  struct Row {
    const char* name;
    sync::Bundle one;
    sync::Bundle other;
    bool contradicts;
  };
  const Row rows[] = {
      {"the same", update(1, 5, 1), update(1, 5, 1), false},
      {"one number, two contents", update(1, 5, 1), update(1, 5, 2), true},
      {"the same but for a sign that decides nothing", update(1, 5, 0.0F), update(1, 5, -0.0F), true},
      {"one number, two ticks", update(1, 5), update(1, 6), true},
      {"one tick, two numbers", update(1, 5), update(2, 5), true},
      {"the later number of the earlier tick", update(2, 5), update(1, 6), true},
      {"one after the other", update(1, 5), update(2, 6), false},
      {"of two peers", update(1, 5, 1, 2), update(1, 5, 2, 3), false},
  };
  for (const Row& r : rows) {
    EXPECT_EQ(wire::contradict(r.one, r.other), r.contradicts) << r.name;
    EXPECT_EQ(wire::contradict(r.other, r.one), r.contradicts) << r.name;
  }
}

TEST_F(Told, WhatProvesALie) {
  struct Row {
    const char* name;
    sync::Bundle told;
    std::uint32_t incarnation;
    bool proves;
  };
  sync::Bundle unsigned_one = update(10, kNow - 50, 2);
  sync::Bundle forged = said(update(10, kNow - 50, 2));
  forged.avatar->position.y = 1;
  const Row rows[] = {
      {"another of that number", said(update(10, kNow - 50, 2)), 3, true},
      {"the same", said(update(10, kNow - 50, 1)), 3, false},
      {"another tick", said(update(10, kNow - 40, 1)), 3, true},
      {"another number of that tick", said(update(11, kNow - 50, 1)), 3, true},
      {"an earlier number of a later tick", said(update(9, kNow - 40)), 3, true},
      {"a later number of an earlier tick", said(update(12, kNow - 60)), 3, true},
      {"a later number of a later tick", said(update(12, kNow - 40)), 3, false},
      {"one that no transfer can tell of, so that joiners could not read it", said(update(1U << 30U, kNow - 50, 1)), 3,
       false},
      {"a later one", said(update(11, kNow - 40, 1)), 3, false},
      {"not signed", unsigned_one, 3, false},
      {"changed by who sent it", forged, 3, false},
      {"of another incarnation", said(update(10, kNow - 50, 2), 2), 2, false},
  };
  s_.log.insert(said(update(10, kNow - 50, 1)));
  for (const Row& r : rows) {
    Testimony rules(s_.session);
    rules.on_updates(3, {2, r.incarnation, {r.told}}, s_.view());
    EXPECT_EQ(rules.convicts(s_.roster.seats[2].at.key), r.proves) << r.name;
  }
}

// The others send both, to whom the log has neither.
TEST_F(Told, BothFromOneMember) {
  const sync::Bundle one = said(update(4, 100, 1));
  const sync::Bundle other = said(update(4, 100, 2));
  from(3, one);
  from(0, other);
  EXPECT_FALSE(convicted()) << "nobody has shown both";
  from(3, other);
  EXPECT_TRUE(convicted());
  ASSERT_EQ(rules_.proofs().size(), 1U);
  EXPECT_TRUE(wire::is_proven(kSession, rules_.proofs()[0]));
}

// Peer 3 signs in peer 2's name, whom this peer knows. Once, only those to whom that incarnation was unknown took the
// proof, and stayed out of a session whose coordinator it was against.
TEST_F(Told, WhoSignsInAnothersNameIsConvicted) {
  for (const PeerId name : {PeerId{2}, s_.roster.self}) {  // once, who was named itself looked at none of its own
    Testimony rules(s_.session);
    s_.roster.seats[1].at = {};
    s_.roster.incarnation = 2;
    const std::uint32_t incarnation = 1U + name;
    for (const float x : {1.0F, 2.0F}) {
      sync::Bundle b = update(4, 100, x, name);
      b.signature = wire::sign_update(wire::signing_key(secret(4)), {kSession, incarnation}, b);
      rules.on_updates(0, {name, incarnation, {b}}, s_.view());
    }
    EXPECT_FALSE(convicted());
    EXPECT_TRUE(rules.convicts(s_.roster.seats[3].at.key)) << name;
  }
}

TEST_F(Told, ItsOwnRepeatThatDiffers) {
  s_.log.insert(said(update(10, kNow - 50, 1)));
  rules_.on_repeat(said(update(10, kNow - 50, 1)), 3, s_.view());
  EXPECT_FALSE(convicted());
  rules_.on_repeat(said(update(10, kNow - 50, 2)), 3, s_.view());
  EXPECT_TRUE(convicted());
}

// It may have the liar as a member. Once, those whom a lying coordinator had shut out were the only ones who knew.
TEST_F(Told, AnotherPartIsToldOfAProof) {
  s_.log.insert(said(update(10, kNow - 50, 1)));
  from(3, said(update(10, kNow - 50, 2)));
  const Endpoint liar = s_.roster.seats[2].at;
  Endpoint outside = ipv4({10, 0, 0, 9}, 7000);
  outside.key.fill(9);
  const auto told = [this](const Endpoint& to, const std::vector<sync::Transfer::Gone>& gone) {
    ListedCommands out;
    rules_.tell(to, gone, s_.view(), out);
    return out.all<wire::Fetched>().size();
  };
  EXPECT_EQ(told(outside, {{s_.roster.seats[3].at, 0, 500}}), 0U) << "nothing is known of that one";
  EXPECT_EQ(told(liar, {{liar, 0, 500}}), 0U);
  EXPECT_EQ(told(outside, {{liar, 0, 500}}), 2U);
  s_.roster.now += Testimony::kAgain - 1;
  EXPECT_EQ(told(outside, {{liar, 0, 500}}), 0U);
  ++s_.roster.now;
  EXPECT_EQ(told(outside, {{liar, 0, 500}}), 2U);
}

TEST_F(Told, AProofIsMadeKnownAndTheLiarIsNotToldSo) {
  s_.log.insert(said(update(10, kNow - 50, 1)));
  from(3, said(update(10, kNow - 50, 2)));
  ListedCommands out;
  rules_.advance(s_.view(), out);
  std::map<Endpoint, int> sent;
  for (const auto& f : out.all<wire::Fetched>()) ++sent[f.to];
  EXPECT_EQ(sent.size(), 2U);
  for (const PeerId p : {PeerId{0}, PeerId{3}}) EXPECT_EQ(sent[s_.roster.seats[p].at], 2) << p;
}

TEST_F(Told, WhoseWorldsDifferCompareWhatTheyHave) {
  for (std::uint32_t i = 0; i < 5; ++i) s_.log.insert(said(update(10 + i, kNow - 90 + 10 * static_cast<Tick>(i))));
  node::Seat& other = s_.roster.seats[3];
  other.same = kNow - 80;
  other.differs_at = kNow - 50;
  other.differs = true;
  int sent = 0;
  for (int i = 0; i < 10; ++i) {
    ListedCommands out;
    rules_.advance(s_.view(), out);
    for (const auto& f : out.all<wire::Fetched>()) {
      EXPECT_EQ(f.to, other.at);
      EXPECT_EQ(f.message.slot, 2);
      ASSERT_EQ(f.message.updates.size(), 3U) << "of the ticks between";
      EXPECT_EQ(f.message.updates[0].tick, kNow - 80);
      ++sent;
    }
    s_.roster.now += Testimony::kAgain;
  }
  EXPECT_EQ(sent, Testimony::kTimes);
}

// It has told this member that all up to a tick were here.
TEST_F(Told, ABrokenPromiseMisleadsAndProvesNothing) {
  s_.log.mark(2, kNow - 20, 10);
  from(3, said(update(10, kNow - 19)));
  EXPECT_FALSE(rules_.misled_by());
  from(3, update(10, kNow - 20));
  EXPECT_FALSE(rules_.misled_by()) << "anybody can say that";
  from(3, said(update(10, kNow - 20)));
  EXPECT_EQ(rules_.misled_by(), PeerId{2});
  EXPECT_FALSE(convicted());
}

TEST_F(Told, InvalidProofsAreNotTaken) {
  Proof p{s_.roster.seats[2].at.key, 3, said(update(4, 100, 1)), said(update(4, 100, 2))};
  Proof wrong = p;
  wrong.other = wrong.one;
  rules_.take(wrong);
  wrong = p;
  wrong.key = s_.roster.seats[3].at.key;
  rules_.take(wrong);
  wrong = p;
  wrong.incarnation = 4;
  rules_.take(wrong);
  EXPECT_TRUE(rules_.proofs().empty());
  rules_.take(p);
  rules_.take(p);
  EXPECT_EQ(rules_.proofs().size(), 1U);
}

// Once, whoever lied after eight others had been convicted went free.
TEST_F(Told, ProofsAgainstPeersThatAreGoneMakeRoom) {
  for (std::uint8_t n = 0; n < sync::Transfer::kMostProofs; ++n) {
    const auto by = [n](sync::Bundle b) {
      b.signature = wire::sign_update(wire::signing_key(secret(100 + n)), {kSession, 3}, b);
      return b;
    };
    rules_.take({wire::public_key(secret(100 + n)), 3, by(update(4, 100, 1)), by(update(4, 100, 2))});
  }
  const std::vector<Proof> before = rules_.proofs();
  ASSERT_EQ(before.size(), sync::Transfer::kMostProofs);
  s_.log.insert(said(update(10, kNow - 50, 1)));
  from(3, update(10, kNow - 50, 2));
  EXPECT_TRUE(rules_.convicts(before.front().key)) << "what proves nothing takes nobody's place";
  from(3, said(update(10, kNow - 50, 2)));
  EXPECT_TRUE(convicted());
  EXPECT_EQ(rules_.proofs().size(), sync::Transfer::kMostProofs);
}

TEST_F(Told, SignaturesAreCheckedInMeasure) {
  s_.log.insert(said(update(10, kNow - 50, 1)));
  for (int i = 0; i < Testimony::kMostChecks; ++i) from(3, update(10, kNow - 50, 2));
  from(3, said(update(10, kNow - 50, 2)));
  EXPECT_FALSE(convicted());
  s_.roster.now += kTicksPerSecond;
  from(3, said(update(10, kNow - 50, 2)));
  EXPECT_TRUE(convicted());
}

}  // namespace
}  // namespace padr::test
