#include "common/reckoning/prediction.h"

#include <algorithm>

#include "common/world/avatar_control.h"

namespace padr::sync {
namespace {

float extent(const BodyDef& d) {
  return d.shape == ShapeKind::kCircle ? d.radius : length(d.half);
}

// Box2D lets shapes touch a little before they meet.
constexpr float kTouch = 0.05F;  // m

/// 1 for a contact now, 0 for one at the end of the look-ahead or none.
float urgency(Tick contact_in, int steps) {
  return contact_in < 0 ? 0 : 1 - static_cast<float>(contact_in) / static_cast<float>(steps + 1);
}

}  // namespace

struct InteractionPredictor::Run {
  Tick contact_in = -1;
  std::vector<Vec2> bodies;  ///< where the copied bodies ended, m
};

InteractionPredictor::InteractionPredictor(const Scene& scene, int slots, PeerId self, const Technique& technique)
    : scene_(scene), self_(self), technique_(technique), sandbox_(scene, slots) {
  sandbox_.set_present(sandbox_.avatar(self), true);
  sandbox_.set_free(self, true);
}

InteractionPredictor::~InteractionPredictor() = default;

Prediction InteractionPredictor::predict(const world::View& live, Vec2 target, const FoldState& modelled) {
  const EntityId avatar = live.avatar(self_);
  const Course course{live.position(avatar), live.velocity(avatar), target};
  switch (technique_.predictor) {
    case Predictor::kNone:
      return {};
    case Predictor::kDensity:
    case Predictor::kPathDensity:
      return density(live, target);
    case Predictor::kLookahead:
      if (!anything_in_the_way(live, course)) return {};
      copy_surroundings(live);
      return lookahead(target);
    case Predictor::kPcc:
      if (!anything_in_the_way(live, course) && !anything_in_the_way(live, believed_course(modelled))) return {};
      copy_surroundings(live);
      return cost(live, target, modelled);
  }
  return {};
}

// Stepping a copy is dear, most looks find nothing, and geometry tells: the avatar stays close to the straight way to
// its target. What it leaves it by is the sideways and backward part of its velocity, which dies away with all that the
// velocity is wrong by: first at the force limit, then by the damping. Bodies come closer by their own speed.
bool InteractionPredictor::anything_in_the_way(const world::View& live, const Course& course) const {
  const AvatarDef& a = scene_.avatar;
  const float seconds = kTickSeconds * static_cast<float>(technique_.steps);
  const Vec2 way = course.target - course.from;
  const Vec2 wanted = clamp_length(way * (a.stiffness / a.damping), a.max_speed);
  const Vec2 ahead = clamp_length(way, 1.0F);
  const float along = std::max(0.0F, dot(course.velocity, ahead));
  const float astray = length(course.velocity - ahead * along);
  const float wrong = length(wanted - course.velocity);
  const float turn = astray * (wrong * a.mass / (2 * a.max_force) + 1 / a.damping);
  const float speed = std::max(a.max_speed, length(course.velocity));
  const Vec2 to = course.from + clamp_length(way, speed * seconds);
  for (EntityId b = 0; b < live.bodies(); ++b) {
    const float gap = distance_to_segment(live.position(b), course.from, to) - extent(scene_.bodies[b]) - a.radius;
    const float comes = live.awake(b) ? length(live.velocity(b)) * seconds : 0;
    if (gap <= turn + comes + kTouch) return true;
  }
  return false;
}

void InteractionPredictor::copy_surroundings(const world::View& live) {
  const Vec2 centre = live.position(live.avatar(self_));
  far_.assign(static_cast<std::size_t>(live.entities()), true);
  far_[live.avatar(self_)] = false;
  for (EntityId b = 0; b < live.bodies(); ++b)
    far_[b] = distance(live.position(b), centre) - extent(scene_.bodies[b]) > technique_.radius;
  for (EntityId b = 0; b < live.bodies(); ++b) sandbox_.set_present(b, !far_[b]);
  sandbox_.restore(live.snapshot(), far_);
}

InteractionPredictor::Run InteractionPredictor::run(Vec2 target) {
  Run result;
  const EntityId avatar = sandbox_.avatar(self_);
  for (Tick t = 1; t <= technique_.steps; ++t) {
    world::drive_avatar(sandbox_, self_, target);
    sandbox_.step();
    ++steps_;
    const auto& contacts = sandbox_.contacts();
    const bool touches =
        std::any_of(contacts.begin(), contacts.end(), [avatar](const Contact& c) { return c.second == avatar; });
    if (touches && result.contact_in < 0) result.contact_in = t;
    if (touches && technique_.predictor == Predictor::kLookahead) break;
  }
  if (technique_.predictor != Predictor::kPcc) return result;
  for (EntityId b = 0; b < sandbox_.bodies(); ++b)
    if (!far_[b]) result.bodies.push_back(sandbox_.position(b));
  return result;
}

Prediction InteractionPredictor::lookahead(Vec2 target) {
  const Run ahead = run(target);
  return {ahead.contact_in >= 0, urgency(ahead.contact_in, technique_.steps), 0, ahead.contact_in};
}

InteractionPredictor::Course InteractionPredictor::believed_course(const FoldState& modelled) const {
  const world::Kinematics& m = modelled.world.entities[sandbox_.avatar(self_)];
  const AvatarModel& model = modelled.avatars[self_];
  const Vec2 target = model.kind == Model::kInput
                          ? model.control
                          : m.position + m.velocity * (kTickSeconds * static_cast<float>(technique_.steps));
  return {m.position, m.velocity, target};
}

// The cost the paper defines, by its definition: what the avatar's model error does to bodies. Once from where the
// avatar is, once from where its model is; the bodies' difference at the end is the cost.
Prediction InteractionPredictor::cost(const world::View& live, Vec2 target, const FoldState& modelled) {
  const Run truth = run(target);
  sandbox_.restore(live.snapshot(), far_);
  const EntityId avatar = sandbox_.avatar(self_);
  const world::Kinematics& m = modelled.world.entities[avatar];
  sandbox_.set_state(avatar, {m.position, 0, m.velocity, 0, true});
  const Run believed_run = run(believed_course(modelled).target);
  Prediction p;
  for (std::size_t i = 0; i < truth.bodies.size(); ++i) p.cost_m += distance(truth.bodies[i], believed_run.bodies[i]);
  p.contact_in = truth.contact_in;
  p.interaction = p.cost_m > technique_.pcc_bound;
  p.level = technique_.pcc_bound > 0 ? std::min(1.0F, p.cost_m / technique_.pcc_bound) : 1.0F;
  return p;
}

Prediction InteractionPredictor::density(const world::View& live, Vec2 target) const {
  const Vec2 from = live.position(live.avatar(self_));
  const float way = scene_.avatar.max_speed * kTickSeconds * static_cast<float>(technique_.steps);
  const bool along_path = technique_.predictor == Predictor::kPathDensity;
  const Vec2 to = along_path ? from + clamp_length(target - from, way) : from;
  int n = 0;
  for (EntityId b = 0; b < live.bodies(); ++b) {
    const float gap = distance_to_segment(live.position(b), from, to) - extent(scene_.bodies[b]);
    if (gap <= (along_path ? 2 * scene_.avatar.radius : technique_.radius)) ++n;
  }
  const int dense = along_path ? 1 : technique_.count;
  return {n >= dense, std::min(1.0F, static_cast<float>(n) / static_cast<float>(dense)), 0, -1};
}

}  // namespace padr::sync
