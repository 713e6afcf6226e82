#pragma once

#include <cstdint>
#include <vector>

#include "common/model/scene.h"
#include "common/scenarios/input.h"

namespace padr::scenarios {

struct WanderOptions {
  Vec2 lower, upper;     ///< m, the play area; never left
  Vec2 start;            ///< m, where tick 0 is
  float margin = 1;      ///< m, distance of goals from the area's edges (less in a small area)
  float peak_speed = 5;  ///< m/s, the most a reach gets to, so that an avatar can follow
  int slot = 0;          ///< slots wander independently from the same seed
};

/// For an avatar of a scene: its play area and start, goals the avatar can stand on, nine tenths of its top speed.
WanderOptions wander_options(const Scene& scene, int slot);

/// Made-up motion with the gross features of a person's: point-to-point reaches with the minimum-jerk speed profile
/// (Flash and Hogan, J. Neuroscience 5(7), 1985), slightly bowed, lasting as Fitts's law says (MacKenzie 1992: a + b
/// log2(distance / goal size + 1)) or longer where that would be faster than peak_speed, and pauses between them.
///
/// Time is cut into chapters, each planned from (seed, chapter) alone and each ending where the next one begins: any
/// tick can be asked for at any time without having gone through those before it, and memory stays bounded.
class Wander : public InputSource {
 public:
  Wander(const WanderOptions& options, std::uint64_t seed);
  Vec2 target(Tick tick) override;

 private:
  struct Reach {
    Tick begin, end;  ///< in the chapter; before `begin` the target rests at `from`
    Vec2 from, to;
    double bow;  ///< sideways bulge as part of the distance
  };

  /// Where chapter `number` begins.
  Vec2 anchor(std::int64_t number) const;
  Vec2 random_point(std::uint64_t stream_seed) const;
  Tick reach_ticks(Vec2 from, Vec2 to, double goal_size) const;
  void plan(std::int64_t number);
  Vec2 on_reach(const Reach& reach, Tick tick) const;

  WanderOptions options_;
  std::uint64_t seed_;
  Tick chapter_ticks_;
  std::int64_t planned_ = -1;
  std::vector<Reach> reaches_;  ///< of the planned chapter, in order; never empty
};

}  // namespace padr::scenarios
