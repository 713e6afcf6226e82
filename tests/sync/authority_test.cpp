#include "common/sync/authority.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "common/model/rng.h"
#include "tests/seed.h"

namespace padr::sync {
namespace {

Authority claim(PeerId owner, std::uint32_t epoch, Tick claimed, bool released = false) {
  return {owner, released, epoch, claimed};
}

struct Row {
  const char* what;
  Authority challenger;
  Authority present;
  bool wins;
};

TEST(Authority, Table) {
  const Authority nobody;
  const std::vector<Row> rows{
      {"the first claim", claim(1, 1, 10), nobody, true},
      {"a higher epoch, though later", claim(1, 3, 90), claim(2, 2, 10), true},
      {"a lower epoch, though earlier", claim(1, 1, 5), claim(2, 2, 10), false},
      {"the same epoch, earlier", claim(1, 2, 9), claim(2, 2, 10), true},
      {"the same epoch, later", claim(1, 2, 11), claim(2, 2, 10), false},
      {"the owner's next update", claim(1, 2, 10), claim(1, 2, 10), true},
      {"the owner's release", claim(1, 2, 10, true), claim(1, 2, 10), true},
      {"the owner's update after its release", claim(1, 2, 10), claim(1, 2, 10, true), false},
      {"the loser's later update, its claim being later", claim(1, 2, 12), claim(2, 2, 10, true), false},
      {"a new claim after a release", claim(1, 3, 40), claim(2, 2, 10, true), true},
      {"the owner's update under another claim tick", claim(1, 2, 11), claim(1, 2, 10), false},
  };
  for (const Row& r : rows) EXPECT_EQ(wins(r.challenger, r.present, 7), r.wins) << r.what;
}

// Against a record of peer 1, epoch 5, claimed at tick 900; told at tick 1,000 unless a row says otherwise.
TEST(Authority, WhatAClaimMayRestOn) {
  const Authority record{1, false, 5, 900};
  struct Rest {
    const char* name;
    Authority claim;
    Tick told;
    bool may;
  };
  const Rest rows[] = {
      {"the next epoch", {2, false, 6, 1000}, 1000, true},
      {"claims between were declared void", {2, false, 5 + 128, 1000}, 1000, true},
      {"more than can have been", {2, false, 5 + 129, 1000}, 1000, false},
      {"it waited for room in an update", {2, false, 6, 880}, 1000, true},
      {"it cannot have waited that long", {2, false, 6, 879}, 1000, false},
      {"the owner's own, made long ago", {1, false, 5, 900}, 5000, true},
      {"another's of that epoch, said to be older", {2, false, 5, 100}, 1000, false},
  };
  for (const Rest& r : rows) EXPECT_EQ(may_rest_on(r.claim, record, r.told), r.may) << r.name;
}

TEST(Authority, TieOfTickIsDecidedTheSameWayFromBothSidesAndFavoursNobody) {
  int first = 0;
  for (EntityId body = 0; body < 1000; ++body) {
    const Authority a = claim(0, 5, 10);
    const Authority b = claim(1, 5, 10);
    ASSERT_NE(wins(a, b, body), wins(b, a, body));
    first += wins(a, b, body) ? 1 : 0;
  }
  EXPECT_GT(first, 400);
  EXPECT_LT(first, 600);
}

// Whatever order claims of different peers arrive in, the same one is left standing.
TEST(Authority, ArrivalOrderDoesNotMatter) {
  Rng rng(test::seed());
  for (int round = 0; round < 2000; ++round) {
    std::vector<Authority> claims;
    for (PeerId p = 0; p < 5; ++p)
      claims.push_back(claim(p, 1 + rng.below(3), static_cast<Tick>(rng.below(4)), rng.chance(0.3)));
    const auto settle = [&claims] {
      Authority standing;
      for (const Authority& c : claims)
        if (wins(c, standing, 3)) standing = c;
      return standing;
    };
    const Authority expected = settle();
    for (int shuffle = 0; shuffle < 10; ++shuffle) {
      for (std::size_t i = claims.size(); i > 1; --i)
        std::swap(claims[i - 1], claims[rng.below(static_cast<std::uint32_t>(i))]);
      ASSERT_EQ(settle(), expected) << "round " << round;
    }
  }
}

}  // namespace
}  // namespace padr::sync
