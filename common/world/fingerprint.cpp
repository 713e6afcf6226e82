#include "common/world/fingerprint.h"

#include <array>
#include <cmath>

#include "common/model/hash.h"
#include "common/model/rng.h"
#include "common/world/habits.h"
#include "common/world/world.h"

namespace padr::world {
namespace {

BodyDef fixed(Vec2 position, Vec2 half, float angle) {
  BodyDef b;
  b.shape = ShapeKind::kBox;
  b.half = half;
  b.position = position;
  b.angle = angle;
  return b;
}

BodyDef thrown(int i, Vec2 position, double speed, Rng& rng) {
  BodyDef b;
  b.shape = i % 2 == 0 ? ShapeKind::kBox : ShapeKind::kCircle;
  b.radius = 0.3F;
  b.half = {0.2F + 0.02F * static_cast<float>(i % 5), 0.3F};
  b.mass = 1.0F + static_cast<float>(i % 7);
  b.position = position;
  b.angle = static_cast<float>(rng.uniform(-3, 3));
  b.velocity = {static_cast<float>(rng.uniform(-speed, speed)), static_cast<float>(rng.uniform(-speed, speed))};
  return b;
}

Scene empty_scene() {
  Scene s;
  s.name = "fingerprint";
  s.gravity = {0, -9.8F};
  s.warm_starting = true;
  s.continuous = true;
  return s;
}

/// Circles and tilted boxes, each far from all others, fall on a slope: no step solves two contacts together, so the
/// order of contacts has no part in it. The last one begins beyond where the world ends.
Scene loners() {
  Scene s = empty_scene();
  s.upper = {110, 40};
  Rng rng(0x616C6F6E);
  for (int i = 0; i < 8; ++i)
    s.bodies.push_back(thrown(i, {20.0F * static_cast<float>(i), 10.0F + static_cast<float>(i)}, 1, rng));
  s.statics.push_back(fixed({70, -1}, {120, 1}, 0.05F));
  return s;
}

/// The same thrown together in a small pit: friction, rotation, stacking, sleeping.
Scene pile() {
  Scene s = empty_scene();
  Rng rng(0x70616472);
  for (int i = 0; i < 24; ++i) {
    const auto place = static_cast<float>(i);
    s.bodies.push_back(thrown(i, {1.0F + static_cast<float>(i % 6), 1.0F + std::floor(place / 6.0F)}, 4, rng));
  }
  s.statics = {fixed({3.5F, -1}, {6, 1}, 0.05F), fixed({-1, 4}, {1, 8}, 0), fixed({8, 4}, {1, 8}, 0)};
  return s;
}

/// What Box2D gets for the functions that it calls. The C library's sines differ from ours in one of eighty numbers.
std::uint64_t hash_of_functions() {
  Rng rng(0x73696E65);
  Hasher h;
  for (int i = 0; i < 2'000; ++i) {
    const auto x = static_cast<float>(rng.uniform(-8, 8));
    const auto y = static_cast<float>(rng.uniform(-8, 8));
    h.add(::sinf(x), ::cosf(x));
    h.add(::atan2f(y, x), ::sqrtf(std::fabs(x)));
  }
  return h.value();
}

std::uint64_t hash_of(const Scene& scene) {
  World world(scene, 0);
  WideHasher h;
  Snapshot snapshot;
  for (int t = 0; t < 240; ++t) {
    world.step();
    if (t % 20 != 19) continue;
    world.save(snapshot);
    add_to_hash(h, snapshot);
  }
  return h.value();
}

/// A part of the fingerprint.
struct Part {
  unsigned shift;
  unsigned bits;

  std::uint64_t of(std::uint64_t fingerprint) const { return fingerprint >> shift & ((std::uint64_t{1} << bits) - 1); }
  std::uint64_t with(std::uint64_t value) const { return (value & ((std::uint64_t{1} << bits) - 1)) << shift; }
};
constexpr Part kHabitBits{56, 8};
constexpr Part kFunctions{40, 16};
constexpr Part kLoners{24, 16};
constexpr Part kPile{0, 24};

bool has(std::uint64_t fingerprint, Habit h) {
  return (kHabitBits.of(fingerprint) & static_cast<unsigned>(h)) != 0;
}

struct HabitWords {
  Habit habit;
  const char* is;
  const char* cure;
};
constexpr std::array<HabitWords, 8> kHabits{{
    {Habit::kFuses, "fuses multiplications and additions", "compile it with -ffp-contract=off"},
    {Habit::kBox2dFuses, "has a Box2D that fuses multiplications and additions",
     "compile Box2D with -ffp-contract=off, see PADR_BOX2D_SOURCE"},
    {Habit::kWide, "computes with more digits than float has", "compile it for SSE2, -mfpmath=sse"},
    {Habit::kReorders, "adds in another order than written", "compile it without -ffast-math"},
    {Habit::kFlushes, "takes tiny numbers for 0", "link it without -ffast-math"},
    {Habit::kRoundsAway, "does not round to the nearest", "look for what sets the rounding"},
    {Habit::kOtherBytes, "has the highest byte of a number first", "use a little-endian machine"},
    {Habit::kOtherBox2d, "has another Box2D than 2.4", "compile it with Box2D 2.4.1"},
}};

}  // namespace

std::uint64_t physics_fingerprint() {
  return kHabitBits.with(own_habits()) | kFunctions.with(hash_of_functions()) | kLoners.with(hash_of(loners())) |
         kPile.with(hash_of(pile()));
}

std::string physics_difference(std::uint64_t a, std::uint64_t b, const std::string& first, const std::string& second) {
  if (a == b) return "";
  std::string text;
  for (const HabitWords& w : kHabits) {
    if (has(a, w.habit) == has(b, w.habit)) continue;
    if (!text.empty()) text += "; ";
    text += (has(a, w.habit) ? first : second) + ' ' + w.is + ": " + w.cure;
  }
  if (!text.empty()) return text;
  if (kFunctions.of(a) != kFunctions.of(b))
    return "sines, cosines, arc tangents or roots differ: look for a library that replaces the program's own";
  if (kLoners.of(a) != kLoners.of(b)) return "single bodies move differently: run the same release with Box2D 2.4.1";
  return "contacts are solved in another order: run the same release with Box2D 2.4.1";
}

std::string habits_text(std::uint64_t fingerprint) {
  std::string text;
  for (const HabitWords& w : kHabits)
    if (has(fingerprint, w.habit)) text += (text.empty() ? "" : "; ") + std::string(w.is) + ": " + w.cure;
  return text;
}

}  // namespace padr::world
