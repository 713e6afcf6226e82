#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/model/ids.h"
#include "common/scenarios/scenarios.h"
#include "common/scenarios/shapes.h"
#include "tests/scenarios/support.h"

namespace padr::scenarios {
namespace {

using testing::error_of;
using testing::first_seed;

TEST(Embedded, NamesAreSortedAndTheFilesCallThemselvesByThem) {
  const auto names = embedded_names();
  const std::vector<std::string_view> expected{"arena", "ball", "clutter", "dominoes", "pitch", "proxy", "van"};
  EXPECT_EQ(names, expected);
  for (const auto name : names) EXPECT_EQ(load_embedded(name, 1).name, name);
}

TEST(Embedded, AnUnknownNameIsRefusedWithTheNames) {
  EXPECT_EQ(error_of([] { load_embedded("arenas", 1); }),
            "scenario: \"arenas\" is not built in, allowed: arena, ball, clutter, dominoes, pitch, proxy, van");
}

struct Golden {
  const char* name;
  std::uint64_t seed;
  std::uint64_t hash;
};

// A change here is a change of what peers of different builds agree on and of every recorded result: only on purpose.
const Golden kGoldens[] = {
    {"arena", 1, 0xAF0D077A97CEE944U},    {"arena", 2, 0x83EB1B7E5A7DA39BU},    {"ball", 1, 0x77FBCF9377750C62U},
    {"ball", 2, 0x77FBCF9377750C62U},     {"clutter", 1, 0x4AC6DF25A2D20B6EU},  {"clutter", 2, 0xCABDDF00163DA6E6U},
    {"dominoes", 1, 0xEFD43DFE7419C3DBU}, {"dominoes", 2, 0xEFD43DFE7419C3DBU}, {"pitch", 1, 0x03EB5C97CFB76ADDU},
    {"pitch", 2, 0x0103869826972707U},    {"proxy", 1, 0xE7D9FB1647F3F27FU},    {"proxy", 2, 0xE7D9FB1647F3F27FU},
    {"van", 1, 0x8B7535E0ACB48AD9U},      {"van", 2, 0x8B7535E0ACB48AD9U},
};

TEST(Embedded, ScenesAreTheSameToTheBitEverywhere) {
  for (const Golden& g : kGoldens) {
    const std::uint64_t first = scene_hash(load_embedded(g.name, g.seed));
    const std::uint64_t second = scene_hash(load_embedded(g.name, g.seed));
    EXPECT_EQ(first, second) << g.name << ": differs within one process";
    EXPECT_EQ(first, g.hash) << g.name << " seed " << g.seed << std::hex << ": 0x" << first;
  }
}

void expect_apart(const BodyDef& a, const BodyDef& b, double gap, const std::string& what) {
  // Points halfway between floats can land either way; a micrometre is far below anything physics sees.
  EXPECT_GE(separation(a, b), gap - 1e-6) << what;
}

void expect_good_start(const Scene& scene, double gap, const std::string& what) {
  std::vector<BodyDef> moving = scene.bodies;
  for (const Vec2 spawn : scene.avatar.spawns) {
    BodyDef avatar;
    avatar.radius = scene.avatar.radius;
    avatar.position = spawn;
    moving.push_back(avatar);
  }
  for (std::size_t i = 0; i < moving.size(); ++i) {
    const std::string which = what + " thing " + std::to_string(i);
    const Vec2 half = extent(moving[i]);
    EXPECT_GE(moving[i].position.x - half.x, scene.lower.x) << which;
    EXPECT_GE(moving[i].position.y - half.y, scene.lower.y) << which;
    EXPECT_LE(moving[i].position.x + half.x, scene.upper.x) << which;
    EXPECT_LE(moving[i].position.y + half.y, scene.upper.y) << which;
    for (std::size_t j = 0; j < i; ++j) expect_apart(moving[i], moving[j], gap, which + " " + std::to_string(j));
    for (const BodyDef& fixed : scene.statics) expect_apart(moving[i], fixed, 0, which + " wall");
  }
}

TEST(Embedded, NothingOverlapsForAnySeed) {
  const std::uint64_t first = first_seed();
  for (const auto name : embedded_names()) {
    const bool random = name == "arena" || name == "clutter" || name == "pitch";
    const double gap = name == "arena" ? 0.1 : name == "clutter" ? 0.05 : 0;
    for (std::uint64_t seed = first; seed < first + (random ? 40 : 1); ++seed) {
      expect_good_start(load_embedded(name, seed), gap, std::string(name) + " seed " + std::to_string(seed));
    }
  }
}

TEST(Embedded, EveryNumberMakesSense) {
  const std::uint64_t first = first_seed();
  for (const auto name : embedded_names()) {
    const Scene scene = load_embedded(name, first);
    EXPECT_LE(scene.avatar.spawns.size(), static_cast<std::size_t>(kMaxPeers)) << name;
    EXPECT_FALSE(scene.title.empty()) << name;
    for (const BodyDef& b : scene.bodies) {
      EXPECT_GT(b.mass, 0) << name;
      EXPECT_TRUE(b.shape == ShapeKind::kCircle ? b.radius > 0 : b.half.x > 0 && b.half.y > 0) << name;
      EXPECT_TRUE(is_finite(b.position) && is_finite(b.velocity) && std::isfinite(b.angle)) << name;
    }
    for (const BodyDef& b : scene.statics) EXPECT_EQ(b.mass, 0) << name;
  }
}

TEST(Embedded, ArenaIsThePapersSetting) {
  const std::uint64_t first = first_seed();
  for (std::uint64_t seed = first; seed < first + 20; ++seed) {
    const Scene scene = load_embedded("arena", seed);
    ASSERT_EQ(scene.bodies.size(), 60U);
    EXPECT_EQ(scene.avatar.spawns.size(), 64U);
    EXPECT_EQ(scene.gravity, (Vec2{0, 0}));
    EXPECT_FALSE(scene.warm_starting || scene.continuous);
    const auto circles = std::count_if(scene.bodies.begin(), scene.bodies.end(),
                                       [](const BodyDef& b) { return b.shape == ShapeKind::kCircle; });
    EXPECT_GT(circles, 10) << "seed " << seed;
    EXPECT_LT(circles, 50) << "seed " << seed;
    for (const BodyDef& b : scene.bodies) {
      EXPECT_GE(b.mass, 4) << "seed " << seed;
      EXPECT_LE(b.mass, 40) << "seed " << seed;
      EXPECT_EQ(b.linear_damping, 1.2F);
    }
  }
}

/// A built-in scenario without its further places to start from.
std::string only_listed_spawns(std::string_view name) {
  std::string text(embedded_text(name));
  const std::size_t at = text.find("more_spawns: ");
  return text.erase(at, text.find('\n', at) - at);
}

TEST(Embedded, FurtherSpawnsLeaveEverythingElseWhereItStands) {
  for (const auto& [name, listed] : {std::pair{"arena", 16U}, std::pair{"pitch", 22U}}) {
    const std::uint64_t seed = first_seed();
    const Scene with = load_embedded(name, seed);
    const Scene without = load(only_listed_spawns(name), name, seed);
    ASSERT_EQ(without.avatar.spawns.size(), listed) << name;
    EXPECT_EQ(with.avatar.spawns.size(), static_cast<std::size_t>(kMaxPeers)) << name;
    EXPECT_TRUE(std::equal(without.avatar.spawns.begin(), without.avatar.spawns.end(), with.avatar.spawns.begin()));
    ASSERT_EQ(with.bodies.size(), without.bodies.size()) << name;
    for (std::size_t b = 0; b < with.bodies.size(); ++b) {
      EXPECT_EQ(with.bodies[b].position, without.bodies[b].position) << name << " body " << b;
      EXPECT_EQ(with.bodies[b].mass, without.bodies[b].mass) << name << " body " << b;
    }
  }
}

TEST(Embedded, DifferentSeedsGiveDifferentPlaces) {
  EXPECT_NE(scene_hash(load_embedded("arena", 1)), scene_hash(load_embedded("arena", 2)));
  EXPECT_NE(scene_hash(load_embedded("arena", 0)), scene_hash(load_embedded("arena", ~0ULL)));
  EXPECT_EQ(scene_hash(load_embedded("van", 1)), scene_hash(load_embedded("van", 2))) << "nothing random in it";
}

TEST(Embedded, WallsStandRoundThePlayAreaAndMeetAtTheCorners) {
  for (const auto name : embedded_names()) {
    const Scene scene = load_embedded(name, 1);
    const float away = name == "pitch" ? 4.0F : 0.0F;
    ASSERT_GE(scene.statics.size(), 4U) << name;
    BodyDef probe;  // walks round just outside the inner faces: always inside some wall
    probe.radius = 0.01F;
    const Vec2 low = scene.lower - Vec2{away + 0.2F, away + 0.2F};
    const Vec2 high = scene.upper + Vec2{away + 0.2F, away + 0.2F};
    for (int i = 0; i <= 100; ++i) {
      const float part = static_cast<float>(i) / 100;
      const float x = low.x + (high.x - low.x) * part;
      const float y = low.y + (high.y - low.y) * part;
      for (const Vec2 p : {Vec2{x, low.y}, Vec2{x, high.y}, Vec2{low.x, y}, Vec2{high.x, y}}) {
        probe.position = p;
        EXPECT_TRUE(std::any_of(scene.statics.begin(), scene.statics.begin() + 4,
                                [&](const BodyDef& wall) { return separation(probe, wall) < -0.01; }))
            << name << " at " << p.x << ", " << p.y;
      }
    }
  }
}

}  // namespace
}  // namespace padr::scenarios
