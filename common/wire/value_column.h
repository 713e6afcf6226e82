#pragma once

#include <algorithm>
#include <initializer_list>

#include "common/model/precision.h"
#include "common/sync/updates.h"

namespace padr::wire {

// The values of states, in the order in which they are told. All of a message are told in steps if all of them can be,
// and otherwise all as floats: one way to say what there is to say.

/// Calls `each` with every value and the step in which it may be told.
template <typename Each>
void each_value(const sync::AvatarUpdate& u, Each each) {
  for (const float v : {u.position.x, u.position.y}) each(v, kPlaceStep);
  for (const float v : {u.velocity.x, u.velocity.y}) each(v, kMotionStep);
  if (u.model != Model::kSecond && u.model != Model::kInput) return;
  for (const float v : {u.control.x, u.control.y}) each(v, u.model == Model::kInput ? kPlaceStep : kMotionStep);
}

template <typename Each>
void each_value(const BodyState& s, Each each) {
  for (const float v : {s.position.x, s.position.y, s.angle}) each(v, kPlaceStep);
  if (!s.awake) return;
  for (const float v : {s.velocity.x, s.velocity.y, s.spin}) each(v, kMotionStep);
}

template <typename Each>
void each_value(const sync::Bundle& b, Each each) {
  if (b.avatar) each_value(*b.avatar, each);
  for (const sync::BodyUpdate& u : b.bodies)
    if (u.has_state) each_value(u.state, each);
}

/// Whether all values of it are told in steps.
template <typename States>
bool all_in_steps(const States& of) {
  bool all = true;
  each_value(of, [&all](float v, float step) { all = all && in_steps(v, step); });
  return all;
}

/// Into a message with the columns `state` and `rounded`.
template <typename States, typename Message>
void put_values(const States& of, Message& out) {
  if (all_in_steps(of)) {
    each_value(of, [&out](float v, float step) { out.add_rounded(to_steps(v, step)); });
  } else {
    each_value(of, [&out](float v, float) { out.add_state(v); });
  }
}

/// Reads them back, one after another.
template <typename Message>
class ValueColumn {
 public:
  explicit ValueColumn(const Message& in) : in_(in) {}

  int left() const { return (in_.rounded().empty() ? in_.state_size() : in_.rounded_size()) - at_; }
  /// If there is one left.
  float next(float step) {
    const int i = at_++;
    if (!in_.rounded().empty()) return from_steps(in_.rounded(i), step);
    const float v = in_.state(i);
    could_be_in_steps_ = could_be_in_steps_ && in_steps(v, step);
    return v;
  }
  Vec2 next_vec(float step) {
    const float x = next(step);
    return {x, next(step)};
  }
  /// If there are enough left: 3 values, or 6 if awake.
  bool take(BodyState& s) {
    if (left() < (s.awake ? 6 : 3)) return false;
    s.position = next_vec(kPlaceStep);
    s.angle = next(kPlaceStep);
    if (!s.awake) return true;
    s.velocity = next_vec(kMotionStep);
    s.spin = next(kMotionStep);
    return true;
  }
  /// After the last: all have been read, and they could not have been told otherwise.
  bool used_up() const {
    if (left() != 0) return false;
    if (in_.rounded().empty()) return in_.state().empty() || !could_be_in_steps_;
    const auto in_range = [](std::int32_t n) { return n >= -kMostSteps && n <= kMostSteps; };
    return in_.state().empty() && std::all_of(in_.rounded().begin(), in_.rounded().end(), in_range);
  }

 private:
  const Message& in_;
  int at_ = 0;
  bool could_be_in_steps_ = true;
};

}  // namespace padr::wire
