#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "common/model/scene.h"
#include "common/model/vec.h"

namespace padr::crowd {

/// A square of the plane: x * side .. (x + 1) * side, and likewise y.
struct Region {
  int x = 0;
  int y = 0;
  friend auto operator<=>(const Region&, const Region&) = default;
};

/// What all peers of a crowd must have alike. docs/crowds.md says what the words mean.
struct Plane {
  float side = 24;        ///< m, of a region
  float reach = 6;        ///< m beyond its border: nearer avatars are guests
  float ahead = 0.8F;     ///< s: or will be so near at its present speed
  float linger = 2;       ///< m more, and the guest leaves
  float threshold = 1;    ///< m inside, and the guest is at home
  float body_past = 0.5;  ///< m beyond the border, and a body is handed over
  int bodies = 18;        ///< in every region at the beginning
  int spare = 12;         ///< body slots besides
  int slots = 32;         ///< avatars in one region at most
  std::uint64_t seed = 1;
};

/// Of all that is in it: peers with another one are not of the same crowd.
std::uint64_t plane_hash(const Plane& plane);

/// Regions are numbered so far from the origin, to either side.
inline constexpr int kMostRegion = 32767;

Region region_at(const Plane& plane, Vec2 p);
bool contains(const std::vector<Region>& regions, Region r);
Vec2 lower_of(const Plane& plane, Region r);
/// Distance from the region's square, m; 0 inside.
float outside(const Plane& plane, Region r, Vec2 p);
/// Distance from the region's border to a point inside, m; negative outside.
float inside(const Plane& plane, Region r, Vec2 p);
/// The regions whose squares are nearer to p than `within`, m, in order.
std::vector<Region> around(const Plane& plane, Vec2 p, float within);
/// The nearest point that is no farther outside than `most`, m.
Vec2 held_near(const Plane& plane, Region r, Vec2 p, float most);

/// Names the region in the names of its bodies; never 0.
std::uint32_t id_of(Region r);
Region region_of(std::uint32_t id);
/// Of the region's session, never 0. Regions with the same number are 255 apart.
std::uint16_t number_of(Region r);

/// The region's part of the plane: a pure function of its coordinates and the plane's seed. Circles and boxes of 10 to
/// 25 kg on a floor with friction, and avatars as in the scenario `arena`.
Scene scene_of(const Plane& plane, Region r);

}  // namespace padr::crowd
