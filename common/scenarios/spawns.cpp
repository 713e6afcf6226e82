#include <algorithm>

#include "common/model/ids.h"
#include "common/model/rng.h"
#include "common/scenarios/scene_draft.h"
#include "common/scenarios/shapes.h"

namespace padr::scenarios {
namespace {

// Names this use of the seed, so that bodies stand where they stood without further spawns.
constexpr std::uint64_t kSpawnStream = 0x59A3;
constexpr double kGap = 0.1;  // m, between an avatar and whatever else is there at the start
// Room for one is found in a few tries unless there is next to none; then those so far have to do.
constexpr int kTries = 4000;

bool clear(const BodyDef& avatar, const std::vector<BodyDef>& others) {
  return std::all_of(others.begin(), others.end(), [&](const BodyDef& other) {
    // Centres far apart need no shapes: most pairs.
    const double far = reach(avatar) + reach(other) + kGap;
    const Vec2 d = avatar.position - other.position;
    return static_cast<double>(dot(d, d)) > far * far || separation(avatar, other) >= kGap;
  });
}

Vec2 draw(Rng& rng, Vec2 lower, Vec2 upper) {
  const auto between = [&rng](float low, float high) {
    return static_cast<float>(rng.uniform(static_cast<double>(low), static_cast<double>(high)));
  };
  const float x = between(lower.x, upper.x);
  return {x, between(lower.y, upper.y)};
}

}  // namespace

void add_spawns(SceneDraft& draft, const Document& document, std::uint64_t seed) {
  const std::uint32_t more = document.scenario().avatar().more_spawns();
  std::vector<Vec2>& spawns = draft.scene.avatar.spawns;
  const Origin origin = document.origin("avatar.more_spawns");
  if (more + spawns.size() > static_cast<std::size_t>(kMaxPeers))
    document.fail(origin, "is " + std::to_string(more) + " beside " + std::to_string(spawns.size()) +
                              " listed, allowed: " + std::to_string(kMaxPeers) + " in all");
  BodyDef avatar;
  avatar.radius = draft.scene.avatar.radius;
  std::vector<BodyDef> others = draft.scene.bodies;
  others.insert(others.end(), draft.scene.statics.begin(), draft.scene.statics.end());
  const auto settle = [&avatar, &others](Vec2 at) {
    avatar.position = at;
    others.push_back(avatar);
  };
  for (const Vec2 spawn : spawns) settle(spawn);
  const float inset = avatar.radius + static_cast<float>(kGap);
  const Vec2 room{inset, inset};
  Rng rng(derive_seed(seed, kSpawnStream, 0));
  for (std::uint32_t n = 0; n < more; ++n) {
    int tries = kTries;
    do {
      if (tries-- == 0) return;
      avatar.position = draw(rng, draft.scene.lower + room, draft.scene.upper - room);
    } while (!clear(avatar, others));
    spawns.push_back(avatar.position);
    settle(avatar.position);
  }
}

}  // namespace padr::scenarios
