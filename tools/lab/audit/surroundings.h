#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "common/sync/fold.h"
#include "tools/lab/audit/limits.h"

namespace padr::lab::audit {

/// Two places, and the longest way between them that something can have taken, m.
struct Way {
  Vec2 from;
  Vec2 to;
  float longest = 0;
  /// Whether something on its way may have come within `reach` of p.
  bool may_reach(Vec2 p, float reach) const {
    return distance(p, from) + distance(p, to) <= std::max(longest, distance(from, to)) + 2 * reach;
  }
};

/// The agreed world of the last kLately ticks: what is where, how fast it was, and what has been left alone. As members
/// predict, and late updates change what they have predicted, things may have been elsewhere for each of them: the
/// margins say how far.
class Surroundings {
 public:
  Surroundings(const Limits& limits, int bodies, int slots);

  /// The agreed world at the begin of the next tick.
  void take(const sync::FoldState& at);
  /// What was said at this tick.
  void hear(const std::vector<sync::Bundle>& said);

  const sync::FoldState& now() const { return now_; }
  Tick tick() const { return now_.tick; }
  bool empty() const { return frames_.empty(); }
  Vec2 position(EntityId e) const { return now_.world.entities[e].position; }
  EntityId avatar(PeerId p) const { return static_cast<EntityId>(bodies_ + static_cast<std::size_t>(p)); }
  std::size_t bodies() const { return bodies_; }

  float fastest_body() const;              ///< m/s
  float fastest_avatar(PeerId but) const;  ///< m/s, of all but one peer's
  /// Since when nobody has owned, held, moved or told of the body.
  Tick calm_since(EntityId body) const { return stirred_[body] + 1; }
  bool is_stirred(EntityId body) const { return now_.tick - stirred_[body] < kStirredFor; }
  /// Whether nothing that others may have moved differently has been within `metres` of a body lately.
  bool is_alone(EntityId body, PeerId but, float metres) const;
  /// How far from where it is agreed to be a body may be for somebody, m.
  float unsure(EntityId body) const;
  /// The part of it that is due to its speed, m.
  float moves_within(EntityId body) const;

  /// Whether peer p's avatar may have touched anything on this way.
  bool may_touch_body(const Way& way) const;
  bool may_touch_avatar(const Way& way, PeerId p) const;
  bool may_touch_obstacle(const Way& way) const;

 private:
  static constexpr Tick kStirredFor = 4 * kTicksPerSecond;
  struct Avatar {
    bool present = false;
    Vec2 position;
    float speed = 0;
  };
  struct Frame {
    float fastest_body = 0;
    std::vector<Avatar> avatars;
  };
  void note_stirred(const sync::FoldState& at);

  const Limits& limits_;
  std::size_t bodies_;
  std::size_t slots_;
  sync::FoldState now_;
  std::deque<Frame> frames_;
  std::vector<Tick> stirred_;  ///< by body
};

}  // namespace padr::lab::audit
