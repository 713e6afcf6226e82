// Who said what with which number, and what of it is proof.
#include <gtest/gtest.h>

#include "common/wire/signature.h"
#include "tools/lab/audit/two_updates.h"

namespace padr::lab::audit {
namespace {

wire::Key secret(std::uint8_t n) {
  wire::Key k{};
  k.fill(n);
  return k;
}

constexpr SessionId kSession{1, 2, 3};

sync::Bundle update(std::uint32_t index, float x) {
  sync::Bundle b;
  b.peer = 1;
  b.index = index;
  b.tick = 100;
  b.avatar = sync::AvatarUpdate{};
  b.avatar->position = {x, 0};
  return b;
}

sync::Bundle signed_update(std::uint32_t index, float x, std::uint8_t by) {
  sync::Bundle b = update(index, x);
  b.signature = wire::sign_update(wire::signing_key(secret(by)), {kSession, 7}, b);
  return b;
}

/// Two traces of a session; slot 1 is known to both.
struct Case {
  Evidence evidence{2};
  MemberId who = 0;
  explicit Case(bool with_key) {
    Member m{1, 7, {}, 50};
    if (with_key) m.key = wire::public_key(secret(1));
    for (std::size_t t = 0; t < 2; ++t) {
      who = evidence.members.note(t, m, 0);
      if (with_key) evidence.traces[t].header.session_id = kSession;
    }
  }
  std::vector<Finding> found() const { return find_two_updates(evidence, {"a", "b"}); }
};

TEST(TwoUpdates, RepeatsAreNone) {
  Case c(true);
  for (std::size_t t = 0; t < 2; ++t) c.evidence.ledger.add(t, c.who, signed_update(3, 1, 1), kNoPeer);
  c.evidence.ledger.add(0, c.who, update(3, 1), 2);  // the same, its signature left out
  EXPECT_TRUE(c.found().empty());
}

TEST(TwoUpdates, TwoSignaturesAreProofAcrossTraces) {
  Case c(true);
  c.evidence.ledger.add(0, c.who, signed_update(3, 1, 1), kNoPeer);
  c.evidence.ledger.add(1, c.who, signed_update(3, 1.5F, 1), 2);
  const auto found = c.found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].is_signed);
  EXPECT_EQ(found[0].who, c.who);
  EXPECT_FLOAT_EQ(found[0].measured, 0.5F);
  EXPECT_EQ(found[0].traces, (std::vector<std::size_t>{0, 1}));
}

TEST(TwoUpdates, WithinOneTraceToo) {
  Case c(true);
  c.evidence.ledger.add(0, c.who, signed_update(3, 1, 1), kNoPeer);
  c.evidence.ledger.add(0, c.who, signed_update(3, 2, 1), kNoPeer);
  EXPECT_EQ(c.found().size(), 1U);
}

// Whoever passes an update on may have invented it: that is not its author's word.
TEST(TwoUpdates, WhatAnotherInventsIsNobodysWord) {
  Case c(true);
  c.evidence.ledger.add(0, c.who, signed_update(3, 1, 1), kNoPeer);
  c.evidence.ledger.add(1, c.who, signed_update(3, 2, 9), 2);
  EXPECT_TRUE(c.found().empty());
}

// From the member's own address, with a signature that is not its own: seen, and no proof.
TEST(TwoUpdates, WithoutAValidSignatureItIsUnproven) {
  Case c(true);
  c.evidence.ledger.add(0, c.who, signed_update(3, 1, 1), kNoPeer);
  c.evidence.ledger.add(0, c.who, signed_update(3, 2, 9), kNoPeer);
  const auto found = c.found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_FALSE(found[0].is_signed);
}

TEST(TwoUpdates, WithoutAKeyItIsSaidWhoPassedItOn) {
  Case c(false);
  c.evidence.ledger.add(0, c.who, update(3, 1), kNoPeer);
  c.evidence.ledger.add(1, c.who, update(3, 2), 0);
  const auto found = c.found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_FALSE(found[0].is_signed);
  EXPECT_EQ(found[0].passed_on_by, 0);
}

// Both sides of a partition let somebody in, and number it alike.
TEST(MembersOfTraces, NumberedAlikeAreTwoIfTheirKeysOrTicksDiffer) {
  Members m(2);
  const PublicKey a = wire::public_key(secret(1));
  const PublicKey b = wire::public_key(secret(2));
  EXPECT_NE(m.note(0, {3, 9, a, 100}, 5), m.note(1, {3, 9, b, 100}, 5));
  EXPECT_NE(m.note(0, {4, 9, {}, 100}, 5), m.note(1, {4, 9, {}, 101}, 5));
  EXPECT_EQ(m.note(0, {5, 9, {}, -1}, 5), m.note(1, {5, 9, b, 101}, 5)) << "what one trace lacks another has";
  EXPECT_EQ(m[*m.sitter(0, 5, 9)].key, b);
}

TEST(MembersOfTraces, NumbersTellTheAuthor) {
  Members m(1);
  const MemberId first = m.note(0, {3, 9, {}, 100}, 5);
  const MemberId second = m.note(0, {3, 11, {}, 200}, 40);
  EXPECT_EQ(m.author(0, 3, 39), first);
  EXPECT_EQ(m.author(0, 3, 40), second);
  EXPECT_FALSE(m.author(0, 3, 4).has_value());
  EXPECT_FALSE(m.author(0, 2, 40).has_value());
}

}  // namespace
}  // namespace padr::lab::audit
