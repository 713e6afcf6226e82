#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/link/netem_spec.h"
#include "common/model/state.h"
#include "common/model/technique.h"
#include "tools/lab/examples/story.h"

namespace padr::lab::examples {

/// A body is disturbed by a model error when it is farther than this from where it is in the other view, m: ten times
/// what is noise.
inline constexpr float kDisturbedMetres = 0.05F;

/// What happened in one run, and when.
struct Course {
  Tick touched = -1;     ///< the avatar's first true contact with a body; -1: none
  double nearest_m = 0;  ///< the least gap that there truly was between the avatar and a body; 0: they touched
  Tick hit = -1;         ///< the model moved a body in the other view that the avatar had not moved; -1: never
  Tick warned = -1;      ///< the predictor's first warning; -1: none
};

/// The physics-consistency cost of one run: how far bodies are from one another in the two peers' views, at the same
/// session ticks, from the start to the end of the story.
struct Cost {
  double mean_m = 0;   ///< sum over bodies, mean over ticks
  double peak_m = 0;   ///< sum over bodies, at its highest
  double final_m = 0;  ///< sum over bodies, at the end, when everything rests
  double area_ms = 0;  ///< sum over bodies, m s
  double ever = 0;     ///< bodies that were disturbed at some tick
  double at_end = 0;   ///< bodies that are disturbed at the end
  std::vector<double> final_by_body_m;
  /// The other view against the true story: what the same input does where the avatar is real and nobody else matters.
  /// Two views can agree on what never would have happened.
  double untrue_mean_m = 0;   ///< sum over bodies, mean over ticks
  double untrue_final_m = 0;  ///< sum over bodies, at the end
  double untrue_at_end = 0;   ///< bodies that are farther than kDisturbedMetres off at the end
  double avatar_mean_m = 0;   ///< how far the moving avatar is off in the other view
  double avatar_peak_m = 0;
  double updates = 0;  ///< told by the moving avatar's peer
  double kbit = 0;     ///< sent by it, IP and UDP headers included
  Course course;       ///< of one run; means have none
};

/// Everything there is in both views at one tick.
struct Moment {
  Tick tick = 0;
  std::vector<BodyState> truth;     ///< in the view of the peer whose avatar moves, by entity id
  std::vector<BodyState> believed;  ///< in the view of the other
};

/// Where a take's bodies go in the world of the avatar that moves, with nothing heard from others and nothing told.
struct TrueStory {
  std::vector<std::vector<Vec2>> bodies;  ///< m, by tick from 1 on and body
  Tick touched = -1;                      ///< the avatar's first contact with a body; -1: none
  Tick nearest = -1;                      ///< when the avatar was nearest to a body
  double nearest_m = 0;                   ///< the gap between them then; 0: they touched
};
TrueStory true_story(const Story& story, int take);

/// Plays a story under a technique: peer 0's avatar moves, peer 1's stays where it is and watches. `on_tick`, if
/// given, sees every tick. The same arguments give the same numbers, to the bit.
Cost measure(const Story& story, int take, const TrueStory& truth, const Technique& technique,
             const link::NetemSpec& netem, const std::function<void(const Moment&)>& on_tick = {});

/// The moment that a story is about: the avatar's first true contact, or, where it stops short, its model's hit in the
/// other view under the fixed threshold without authority. If neither happens, when the avatar was nearest to a body.
Tick moment_of(const Story& story, int take, const TrueStory& truth, const link::NetemSpec& netem);

/// Means over takes.
Cost mean_of(const std::vector<Cost>& takes);

}  // namespace padr::lab::examples
