#include "common/crowd/regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "common/model/hash.h"
#include "common/model/rng.h"

namespace padr::crowd {
namespace {

constexpr std::uint64_t kPlaceStream = 0xC40D;
/// Sessions' numbers repeat after so many regions each way: 255 * 255 numbers fit 16 bits.
constexpr int kNumbers = 255;
/// Where empty slots and avatars that nobody has seen are parked: below the region, one beside the other, m.
constexpr float kBodyRow = 9;
constexpr float kAvatarRow = 12;
constexpr float kRowStep = 1.5F;
/// Bodies start so far from the border, m, so that none begins in two regions.
constexpr float kMargin = 1.2F;
constexpr float kMostExtent = 0.5F;

struct Build {
  ShapeKind shape;
  float radius;
  Vec2 half;
  float mass;
};
constexpr std::array<Build, 3> kBuilds{
    {{ShapeKind::kCircle, 0.3F, {}, 11}, {ShapeKind::kBox, 0, {0.4F, 0.3F}, 17}, {ShapeKind::kCircle, 0.45F, {}, 25}}};

int cell(float v, float side) {
  // What does not fit into an int becomes another one on another processor, so it is made to fit before.
  constexpr auto kMost = static_cast<float>(kMostRegion);
  return static_cast<int>(std::clamp(std::floor(v / side), -kMost, kMost));
}

int wrapped(int v) {
  return (v % kNumbers + kNumbers) % kNumbers;
}

BodyDef body_of(std::size_t build) {
  const Build& b = kBuilds[build];
  BodyDef d;
  d.shape = b.shape;
  d.radius = b.radius;
  d.half = b.half;
  d.mass = b.mass;
  d.linear_damping = 1.2F;
  d.angular_damping = 1.5F;
  return d;
}

AvatarDef avatar_def() {
  AvatarDef a;
  a.stiffness = 40;
  a.damping = 10;
  a.max_force = 1600;
  a.max_speed = 6;
  return a;
}

/// One body in each of the cells of a grid, somewhere in its cell: none touches another.
void strew(const Plane& plane, Region r, Scene& scene) {
  Rng rng(derive_seed(plane.seed, kPlaceStream, id_of(r)));
  const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<float>(plane.bodies))));
  const float room = (plane.side - 2 * kMargin) / static_cast<float>(columns);
  const float play = std::max(0.0F, room / 2 - kMostExtent - 0.1F);
  const Vec2 corner = lower_of(plane, r) + Vec2{kMargin, kMargin};
  for (int i = 0; i < plane.bodies; ++i) {
    BodyDef& d = scene.bodies[static_cast<std::size_t>(i)];
    const int column = i % columns;
    const int row = i / columns;
    const Vec2 middle{(static_cast<float>(column) + 0.5F) * room, (static_cast<float>(row) + 0.5F) * room};
    d.position.x = corner.x + middle.x + static_cast<float>(rng.uniform(-play, play));
    d.position.y = corner.y + middle.y + static_cast<float>(rng.uniform(-play, play));
    if (d.shape == ShapeKind::kBox) d.angle = static_cast<float>(rng.uniform(0, 3.14));
  }
}

}  // namespace

std::uint64_t plane_hash(const Plane& plane) {
  Hasher h;
  h.add(plane.side, plane.reach);
  h.add(plane.ahead, plane.linger);
  h.add(plane.threshold, plane.body_past);
  for (const int n : {plane.bodies, plane.spare, plane.slots}) h.add(static_cast<std::uint64_t>(n));
  h.add(plane.seed);
  return h.value();
}

Region region_at(const Plane& plane, Vec2 p) {
  return {cell(p.x, plane.side), cell(p.y, plane.side)};
}

bool contains(const std::vector<Region>& regions, Region r) {
  return std::find(regions.begin(), regions.end(), r) != regions.end();
}

Vec2 lower_of(const Plane& plane, Region r) {
  return {static_cast<float>(r.x) * plane.side, static_cast<float>(r.y) * plane.side};
}

float outside(const Plane& plane, Region r, Vec2 p) {
  return distance(p, held_near(plane, r, p, 0));
}

float inside(const Plane& plane, Region r, Vec2 p) {
  const Vec2 at = p - lower_of(plane, r);
  return std::min(std::min(at.x, plane.side - at.x), std::min(at.y, plane.side - at.y));
}

Vec2 held_near(const Plane& plane, Region r, Vec2 p, float most) {
  const Vec2 low = lower_of(plane, r);
  return {std::clamp(p.x, low.x - most, low.x + plane.side + most),
          std::clamp(p.y, low.y - most, low.y + plane.side + most)};
}

std::vector<Region> around(const Plane& plane, Vec2 p, float within) {
  std::vector<Region> near;
  const Region first = region_at(plane, p - Vec2{within, within});
  const Region last = region_at(plane, p + Vec2{within, within});
  for (int x = first.x; x <= last.x; ++x)
    for (int y = first.y; y <= last.y; ++y)
      if (outside(plane, {x, y}, p) < within) near.push_back({x, y});
  return near;
}

std::uint32_t id_of(Region r) {
  return static_cast<std::uint32_t>(r.x + kMostRegion + 1) << 16U | static_cast<std::uint32_t>(r.y + kMostRegion + 1);
}

Region region_of(std::uint32_t id) {
  return {static_cast<int>(id >> 16U) - kMostRegion - 1, static_cast<int>(id & 0xFFFFU) - kMostRegion - 1};
}

std::uint16_t number_of(Region r) {
  return static_cast<std::uint16_t>(1 + wrapped(r.x) * kNumbers + wrapped(r.y));
}

Scene scene_of(const Plane& plane, Region r) {
  Scene s;
  s.name = "crowd " + std::to_string(r.x) + "," + std::to_string(r.y);
  s.title = "Region " + std::to_string(r.x) + "," + std::to_string(r.y) + " of a plane without end";
  s.lower = lower_of(plane, r);
  s.upper = s.lower + Vec2{plane.side, plane.side};
  s.avatar = avatar_def();
  const auto parked = [&](int i, float first) {
    const int in_row = static_cast<int>(plane.side / kRowStep);
    const int row = i / in_row;
    return s.lower + Vec2{static_cast<float>(i % in_row) * kRowStep, -first - static_cast<float>(row) * kRowStep};
  };
  for (int p = 0; p < plane.slots; ++p) s.avatar.spawns.push_back(parked(p, kAvatarRow));
  RegionDef region;
  region.id = id_of(r);
  for (int b = 0; b < plane.bodies + plane.spare; ++b) {
    const std::size_t build = static_cast<std::size_t>(b) % kBuilds.size();
    s.bodies.push_back(body_of(build));
    region.builds.push_back(static_cast<std::uint8_t>(build));
    region.empty.push_back(b < plane.bodies ? 0 : 1);
    if (b >= plane.bodies) s.bodies.back().position = parked(b - plane.bodies, kBodyRow);
  }
  strew(plane, r, s);
  s.region = std::move(region);
  return s;
}

}  // namespace padr::crowd
