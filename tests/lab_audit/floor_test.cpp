// How small a lie is found: what docs/audit.md says.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/lab_audit/lies.h"
#include "tests/seed.h"

namespace padr::test {
namespace {

using lab::audit::Kind;

struct Lie {
  const char* name;
  std::vector<Kind> kinds;
  std::vector<float> sizes;  ///< ascending
  float floor;               ///< of this size it is found
  int least;                 ///< so often at least, of kRuns times
  std::function<void(LiarTrial&, float)> tell;
};

/// The calm body whose distance from the liar is nearest to this, m.
EntityId body_at(const LiarTrial& t, float metres) {
  const world::View& world = t.liar().live().world();
  const Vec2 here = world.position(t.liar().live().avatar());
  const auto off = [&](EntityId b) { return std::abs(distance(world.position(b), here) - metres); };
  EntityId best = 0;
  for (EntityId b = 0; b < world.bodies(); ++b)
    if (off(b) < off(best)) best = b;
  return best;
}

const std::vector<Lie>& lies() {
  static const std::vector<Lie> kLies{
      {"teleport by, m", {Kind::kAvatarWay, Kind::kAvatarSpeed}, {1, 2, 3, 4, 6}, 4, 5, teleport},
      {"speed, times", {Kind::kAvatarWay, Kind::kAvatarSpeed}, {1.25F, 1.5F, 1.75F, 2}, 1.75F, 5, speed_up},
      {"claim from, m",
       {Kind::kClaim},
       {5, 8, 11, 14},
       14,
       4,
       [](LiarTrial& t, float metres) { claim_far_body(t, body_at(t, metres)); }},
      {"speed of a body, m/s", {Kind::kBodySpeed}, {8, 10, 12, 15}, 12, 5, give_energy},
      {"body fetched by, m",
       {Kind::kBodyJump, Kind::kClaim},
       {3, 5, 8, 10},
       10,
       2,
       [](LiarTrial& t, float metres) { fetch_body(t, lonely_body(t, metres), metres); }},
  };
  return kLies;
}

/// In how many of `runs` sessions a lie of this size is found.
int found(const Lie& lie, float size, int runs, std::uint64_t seed) {
  int n = 0;
  for (int i = 0; i < runs; ++i) {
    LiarTrial t(seed + static_cast<std::uint64_t>(i),
                i % 2 == 0 ? "delay 30ms 5ms loss 1%" : "delay 100ms 50ms loss 10%");
    lie.tell(t, size);
    t.run(6);
    const lab::audit::Report r = t.report();
    int of_kind = 0;
    for (const Kind k : lie.kinds) of_kind += LiarTrial::count(r, k);
    if (of_kind > 0) ++n;
  }
  return n;
}

constexpr int kRuns = 6;

/// Of one lie.
class DetectionFloor : public testing::TestWithParam<std::size_t> {
 protected:
  const Lie& lie() const { return lies()[GetParam()]; }
};

TEST_P(DetectionFloor, IsWhatTheDocumentsSay) {
  EXPECT_GE(found(lie(), lie().floor, kRuns, test::seed(700)), lie().least) << lie().name;
}

// The table of docs/audit.md.
TEST_P(DetectionFloor, DISABLED_Measure) {
  constexpr int kMany = 10;
  const std::uint64_t seed = test::seed(700);
  for (const float size : lie().sizes)
    std::fprintf(stderr, "%-22s %5.2f: %2d of %d\n", lie().name, static_cast<double>(size),
                 found(lie(), size, kMany, seed), kMany);
}

INSTANTIATE_TEST_SUITE_P(Each, DetectionFloor, testing::Range(std::size_t{0}, lies().size()));

}  // namespace
}  // namespace padr::test
