// What the paper's record of contacts cannot see: see docs/cases.md.
#include <gtest/gtest.h>

#include <set>

#include "tests/lab/session.h"
#include "tests/seed.h"

namespace padr {
namespace {

constexpr Tick kUndisturbed = 30;
constexpr float kApart = 0.05F;  // m
constexpr float kMoves = 0.3F;   // m/s

/// Bodies that nobody owns and that stand still in the first player's world, and yet have been set in motion in the
/// second's: something that is wrong there has hit them. The second player only watches.
std::set<EntityId> hit_in_the_other_view_alone(const Technique& technique, std::uint64_t seed) {
  test::Session s("arena", 2, technique, "", seed, 60, 0, true);
  std::vector<Tick> moved(s.scene.bodies.size(), -kUndisturbed);
  std::set<EntityId> hit;
  s.simulation->run([&](Tick t) {
    const world::View& here = s.simulation->replica(0).live().world();
    const world::View& there = s.simulation->replica(1).live().world();
    for (EntityId b = 0; b < moved.size(); ++b) {
      const bool owned = s.simulation->replica(1).agreed().predicted_state().authority[b].holder() != kNoPeer;
      if (owned || length(here.velocity(b)) > 0) moved[b] = t;
      if (t - moved[b] > kUndisturbed && length(there.velocity(b)) > kMoves &&
          distance(here.position(b), there.position(b)) > kApart)
        hit.insert(b);
    }
  });
  return hit;
}

std::size_t hits(const Technique& technique) {
  const std::uint64_t first = test::seed(1);
  std::size_t n = 0;
  for (std::uint64_t seed = first; seed < first + 6; ++seed) n += hit_in_the_other_view_alone(technique, seed).size();
  return n;
}

// The avatar holds a body, whose updates come at contact begin and end alone. In between the body is wrong in the other
// view and hits a third one there. No contact tells the owner of it.
TEST(Gap, AHeldBodyThatIsWrongElsewhereHitsAThirdOneThere) {
  Technique with_body_threshold = technique_by_name("fixed");
  with_body_threshold.body_threshold = 0.05F;
  const std::size_t papers = hits(technique_by_name("fixed"));
  const std::size_t told = hits(with_body_threshold);
  EXPECT_GE(papers, 6U);
  EXPECT_LE(3 * told, papers) << "bodies told when they are off by 5 cm";
  EXPECT_EQ(hits(technique_by_name("full")), 0U);
}

}  // namespace
}  // namespace padr
