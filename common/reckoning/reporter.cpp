#include "common/reckoning/reporter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/model/precision.h"
#include "common/world/avatar_control.h"

namespace padr::sync {
namespace {

// What is pushed is touched and let go of many times a second; a link is over after this long. The paper reports every
// end at once.
constexpr Tick kPatience = 6;
constexpr float kMisdriven = 0.001F;  // m
// Below this the avatar counts as standing, by its way: where it is jammed, the solver gives it a velocity all the
// same.
constexpr float kStandingSpeed = 0.01F;  // m/s

Tick patience_of(const Technique& t) {
  return t.update_every_contact ? 0 : kPatience;
}

auto first_from(const std::vector<BodyUpdate>& bodies, EntityId b) {
  return std::lower_bound(bodies.begin(), bodies.end(), b,
                          [](const BodyUpdate& u, EntityId id) { return u.body < id; });
}

float rim_of(const BodyDef& d) {
  return d.shape == ShapeKind::kCircle ? 0 : length(d.half);
}

}  // namespace

Reporter::Reporter(const Scene& scene, PeerId self, const Technique& technique)
    : self_(self),
      technique_(technique),
      chain_(static_cast<int>(scene.bodies.size()), static_cast<EntityId>(scene.bodies.size() + self),
             patience_of(technique)),
      aim_(technique.lead),
      choice_(scene.avatar),
      model_error_(technique.time_space),
      no_claim_before_(scene.bodies.size(), 0),
      owned_(scene.bodies.size(), 0),
      claiming_(scene.bodies.size(), 0),
      claim_told_(scene.bodies.size(), -1),
      still_since_(scene.bodies.size(), 0),
      rest_told_(scene.bodies.size(), -kRestAgainTicks) {
  for (const BodyDef& d : scene.bodies) rim_.push_back(rim_of(d));
}

void Reporter::retune(const Technique& technique) {
  technique_ = technique;
  chain_.retune(patience_of(technique));
  aim_.retune(technique.lead);
  model_error_.retune(technique.time_space);
}

const Bundle& Reporter::report(const Situation& s) {
  told_.peer = self_;
  told_.tick = s.predicted->tick;
  avatar_.reset();
  exact_ = false;
  if (technique_.model == Model::kChosen)
    choice_.follow(s.live->world().state(s.live->avatar()), aim_.ahead(way(s)), s.acceleration, way(s));
  const bool all = technique_.update_every_contact;  // those, too, that are over in the step that they begin in
  changes_ = &chain_.update(all ? s.live->touching() : s.live->world().contacts(), s.predicted->tick);
  const auto held = [this](EntityId b) { return chain_.held(b); };
  holding_ = std::any_of(chain_.linked().begin(), chain_.linked().end(), held);
  if (technique_.authority) {
    note_owned(s);
    report_contacts(s);
    report_pushes(s);
    report_proxies(s);
    report_bodies(s);
  }
  report_avatar(s);
  if (!s.may_tell) return tell_nothing();
  if (technique_.authority) {
    bound_the_sum(s);
    complete_cluster(s);
  }
  if (avatar_) model_error_.corrected();
  if (std::exchange(waited_, false)) renew_what_waited(s);
  return finish(s);
}

void Reporter::note_owned(const Situation& s) {
  mine_.clear();
  for (EntityId b = 0; b < owned_.size(); ++b) {
    const bool now = owns(s, b);
    if (now) mine_.push_back(b);
    if (!now && owned_[b] == 0 && claiming_[b] == 0) continue;
    if (now && owned_[b] == 0) still_since_[b] = s.predicted->tick - 1;
    const PeerId holder = s.predicted->authority[b].holder();
    // Of a claim made last tick nothing is owned yet: it may have been lost before it was seen to be won.
    if ((owned_[b] != 0 || claiming_[b] != 0) && !now && holder != kNoPeer) {
      no_claim_before_[b] = s.predicted->tick + s.round_trip;
      ++contests_lost_;
    }
    const bool waits = claiming_[b] != 0 && collected(b) != nullptr;  // did not fit last tick's bundle
    claiming_[b] = waits && !now && holder == kNoPeer ? 1 : 0;
    owned_[b] = now ? 1 : 0;
  }
}

bool Reporter::may_claim(const FoldState& predicted, EntityId b) const {
  const PeerId holder = predicted.authority[b].holder();
  if (holder == self_ || predicted.tick < no_claim_before_[b]) return false;
  return holder == kNoPeer || (predicted.holds[b] & only(holder)) == 0;
}

BodyUpdate& Reporter::entry(EntityId b, Cause cause) {
  auto place = bodies_.begin() + (first_from(bodies_, b) - bodies_.cbegin());
  if (place == bodies_.end() || place->body != b) {
    place = bodies_.insert(place, BodyUpdate{});
    place->cause = cause;
  }
  place->body = b;
  place->held = chain_.held(b);
  return *place;
}

const BodyUpdate* Reporter::collected(EntityId b) const {
  const auto place = first_from(bodies_, b);
  return place != bodies_.end() && place->body == b ? &*place : nullptr;
}

void Reporter::tell_state(const Situation& s, EntityId b, Cause cause) {
  BodyUpdate& u = entry(b, cause);
  const Authority& a = s.predicted->authority[b];
  if (cause == Cause::kAtRest) u.cause = cause;  // whatever else there was to tell of it
  if (!u.has_state) {
    u.epoch = a.epoch;
    u.claimed = a.claimed;
  }
  u.has_state = true;
}

void Reporter::claim(const Situation& s, EntityId b, Cause cause) {
  BodyUpdate& u = entry(b, cause);
  u.has_state = true;
  u.epoch = s.predicted->authority[b].epoch + 1;
  u.claimed = s.predicted->tick;
  claim_told_[b] = s.predicted->tick;
  claiming_[b] = 1;
}

void Reporter::report_contacts(const Situation& s) {
  for (const EntityId b : changes_->begun) {
    report_touch(s, b);
    tell_avatar(s, Cause::kContactBegin);
  }
  // Still touching something that could not be claimed when the touch began.
  for (const EntityId b : chain_.linked())
    if (chain_.touching_now(b, s.predicted->tick) && may_claim(s, b)) claim(s, b, Cause::kContactBegin);
  for (const EntityId b : changes_->ended) {
    entry(b, Cause::kContactEnd);
    if (owns(s, b) && tells_end_state(technique_, error_of(s, b).ahead_metres)) tell_state(s, b, Cause::kContactEnd);
    if (technique_.end_update && technique_.update_every_contact) tell_avatar(s, Cause::kContactEnd);
  }
}

void Reporter::report_touch(const Situation& s, EntityId b) {
  if (owns(s, b)) {
    tell_state(s, b, Cause::kContactBegin);
  } else if (may_claim(s, b)) {
    claim(s, b, Cause::kContactBegin);
  } else {
    entry(b, Cause::kContactBegin);  // only that the avatar touches it
  }
}

void Reporter::report_pushes(const Situation& s) {
  for (const EntityId b : s.pushed) {
    if (owns(s, b)) tell_state(s, b, Cause::kContactBegin);
    if (may_claim(s, b)) claim(s, b, Cause::kContactBegin);
  }
}

void Reporter::report_proxies(const Situation& s) {
  if (!technique_.proxy_update) return;
  if (technique_.update_every_contact) {
    for (const EntityId b : changes_->joined) {
      if (owns(s, b)) tell_state(s, b, Cause::kProxy);
      if (may_claim(s, b)) claim(s, b, Cause::kProxy);
    }
    for (const EntityId b : changes_->left)
      if (owns(s, b)) tell_state(s, b, Cause::kProxy);
    return;
  }
  // Only what the predicted world gets wrong: it plays collisions of bodies among themselves out as well as we do.
  const world::View& live = s.live->world();
  reached_.assign(static_cast<std::size_t>(live.entities()), 0);
  reached_[s.live->avatar()] = 1;
  for (const EntityId b : mine_) reached_[b] = 1;
  found_.clear();
  reach(live.contacts(), live.bodies(), reached_, found_);
  for (const EntityId b : found_) {
    if (collected(b) != nullptr || !may_claim(s, b)) continue;
    if (is_missed_collision(live.position(b), live.velocity(b), s.predicted->world.entities[b]))
      claim(s, b, Cause::kProxy);
  }
}

EntityError Reporter::error_of(const Situation& s, EntityId e) const {
  const float rim = e < rim_.size() ? rim_[e] : 0;  // an avatar does not turn
  return {s.live->world().state(e), s.predicted->world.entities[e], rim};
}

bool Reporter::at_rest(const Situation& s, EntityId b) {
  const BodyState now = s.live->world().state(b);
  if (now.awake && !is_still(now)) still_since_[b] = s.predicted->tick;
  return !now.awake || s.predicted->tick - still_since_[b] >= kStillTicks;
}

void Reporter::report_bodies(const Situation& s) {
  const Tick now = s.predicted->tick;
  for (const EntityId b : mine_) {
    const EntityError e = error_of(s, b);
    const OwnedBody body{e.metres,       e.ahead_metres,
                         e.differs,      s.live->world().state(b).awake,
                         at_rest(s, b),  s.everyone_has >= claim_told_[b],
                         chain_.held(b), now - rest_told_[b]};
    if (!s.may_tell) continue;
    const BodyReason reason = reason_of(body, technique_, s.price);
    if (reason.state) tell_state(s, b, *reason.state);
    if (reason.release) entry(b, Cause::kAtRest).release = true;
    if (reason.state == Cause::kAtRest && body.held) rest_told_[b] = now;
  }
}

// Only the control law yields to what the avatar touches, and comes to rest by itself.
Model Reporter::model_for(Cause cause) const {
  if (technique_.model != Model::kChosen) return technique_.model;
  return cause == Cause::kThreshold && !holding_ ? choice_.best() : Model::kInput;
}

void Reporter::tell_avatar(const Situation& s, Cause cause) {
  if (avatar_) return;
  const BodyState truth = s.live->world().state(s.live->avatar());
  AvatarUpdate u;
  u.cause = cause;
  u.position = truth.position;
  u.velocity = truth.velocity;
  u.awake = truth.awake;
  u.model = model_for(cause);
  if (u.model == Model::kInput) u.control = aim_.ahead(way(s));
  if (u.model == Model::kSecond) u.control = s.acceleration;
  // The last word is exact, or model and avatar would be driven towards different points for ever.
  if (technique_.precision == Precision::kRounded && cause != Cause::kAtRest) {
    u.position = rounded_place(u.position);
    u.velocity = rounded_motion(u.velocity);
    u.control = u.model == Model::kInput ? rounded_place(u.control) : rounded_motion(u.control);
  }
  avatar_ = u;
}

void Reporter::follow_avatar(const Situation& s, const BodyState& truth) {
  const Tick now = s.predicted->tick;
  if (s.target != last_target_) {
    last_target_ = s.target;
    target_since_ = now;
  }
  if (distance(truth.position, last_place_) > kStandingSpeed * kTickSeconds) avatar_moved_ = now;
  last_place_ = truth.position;
  const bool still = !truth.awake || world::has_arrived(truth.position, truth.velocity, s.target);
  if (!still) avatar_driven_ = now;
}

bool Reporter::anything_differs(const Situation& s) const {
  if (error_of(s, s.live->avatar()).differs) return true;
  for (const EntityId b : mine_)
    if (error_of(s, b).differs) return true;
  return false;
}

void Reporter::watch_avatar(const Situation& s) {
  aim_.follow(s.target);
  const EntityId avatar = s.live->avatar();
  const float now = distance(s.live->world().position(avatar), s.predicted->world.entities[avatar].position);
  if (technique_.foresee > 0)
    model_error_.add(now, error_ahead(s));
  else
    model_error_.add(now);
}

float Reporter::error_ahead(const Situation& s) const {
  const EntityId avatar = s.live->avatar();
  const world::Kinematics& believed = s.predicted->world.entities[avatar];
  const AvatarModel& model = s.predicted->avatars[self_];
  const Model kind = model_for(Cause::kThreshold);
  // Contacts are not foreseen: of an avatar that something holds up, one model would have it go on and the other not.
  const auto touches = [avatar](const Contact& c) { return c.first == avatar || c.second == avatar; };
  const std::vector<Contact>& contacts = s.live->world().contacts();
  const bool held_up = !error_of(s, avatar).differs || std::any_of(contacts.begin(), contacts.end(), touches);
  if (kind != model.kind && held_up) return 0;
  const auto later = [&](Model m, const AvatarMoment& from) {
    return choice_.foretold(m, from, static_cast<Tick>(std::lround(technique_.foresee * kTicksPerSecond)));
  };
  const world::View& live = s.live->world();
  const Vec2 told = later(kind, {live.position(avatar), live.velocity(avatar), aim_.ahead(way(s)), s.acceleration});
  return distance(told, later(model.kind, {believed.position, believed.velocity, model.control, model.control}));
}

OwnAvatar Reporter::own_avatar(const Situation& s, const BodyState& truth) const {
  const Tick now = s.predicted->tick;
  const world::Kinematics& believed = s.predicted->world.entities[s.live->avatar()];
  const AvatarModel& model = s.predicted->avatars[self_];
  OwnAvatar a;
  a.present = model.present;
  a.off = model_error_.exceeds(s.threshold);
  a.awake = truth.awake;
  a.steady = now - target_since_;
  a.stands = now - avatar_moved_;
  a.undriven = now - avatar_driven_;
  a.since_settled = now - settled_told_;
  a.since_rest = now - avatar_rest_told_;
  a.misdriven = model.kind == Model::kInput && distance(model.control, s.target) > kMisdriven;
  a.misplaced = distance(truth.position, believed.position) > kMisdriven;
  a.differs = truth.position != believed.position || believed.awake;
  a.any_differs = may_end_exactly(a) && anything_differs(s);
  return a;
}

void Reporter::report_avatar(const Situation& s) {
  const BodyState truth = s.live->world().state(s.live->avatar());
  follow_avatar(s, truth);
  if (!s.may_tell) return;
  const AvatarReason reason = reason_of(own_avatar(s, truth), technique_);
  if (!reason.cause) return;
  tell_avatar(s, *reason.cause);
  if (*reason.cause != Cause::kAtRest) return;
  exact_ = reason.exact;
  if (!reason.asleep) {
    settled_told_ = s.predicted->tick;
    return;
  }
  avatar_rest_told_ = s.predicted->tick;
  avatar_->awake = false;
  avatar_->velocity = {};
}

// Every entity may be within its own threshold and all of them together too far off. They never are by more than the
// largest errors allowed of an avatar and of a body: then everything is told that is off at all.
void Reporter::bound_the_sum(const Situation& s) {
  if (technique_.body_threshold <= 0) return;
  const float avatar_error = avatar_ ? 0 : error_of(s, s.live->avatar()).soon_metres;
  float sum = avatar_error;
  for (const EntityId b : mine_) {
    const BodyUpdate* told = collected(b);
    if (told == nullptr || !told->has_state) sum += error_of(s, b).soon_metres;
  }
  if (sum <= (technique_.threshold_high + technique_.body_threshold) * s.price) return;
  if (avatar_error > kAlongMetres) tell_avatar(s, Cause::kThreshold);
  for (const EntityId b : mine_)
    if (error_of(s, b).ahead_metres > kAlongMetres) tell_state(s, b, Cause::kBodyThreshold);
}

// An avatar that is put right while the body it pushes is not would be inside it, and the solver would fling them
// apart.
void Reporter::complete_cluster(const Situation& s) {
  if (technique_.update_every_contact) return;
  const world::Kinematics& believed = s.predicted->world.entities[s.live->avatar()];
  const Vec2 truth = s.live->world().position(s.live->avatar());
  bool body_told = false;
  for (const BodyUpdate& u : bodies_) body_told = body_told || (u.has_state && u.held);
  if (body_told && distance(truth, believed.position) > kAlongMetres) tell_avatar(s, Cause::kBodyThreshold);
  if (!avatar_) return;
  for (const EntityId b : mine_)
    if ((chain_.member(b) && error_of(s, b).metres > kAlongMetres) || (exact_ && error_of(s, b).differs))
      tell_state(s, b, exact_ ? Cause::kBodyThreshold : avatar_->cause);
}

const Bundle& Reporter::tell_nothing() {
  waited_ = true;
  told_.avatar.reset();
  told_.bodies.clear();
  return told_;
}

// What the claims rested on may have changed while they waited, and a touch may be over that nobody was told of: then
// the body has gone on as predicted. What is still touched has been claimed anew.
void Reporter::renew_what_waited(const Situation& s) {
  std::erase_if(bodies_, [&](BodyUpdate& u) {
    const Authority& a = s.predicted->authority[u.body];
    const bool known_as_held = (s.predicted->holds[u.body] & only(self_)) != 0;
    if (u.has_state && owns(s, u.body)) {
      u.epoch = a.epoch;
      u.claimed = a.claimed;
    } else if (!u.has_state || !may_claim(s, u.body) || !chain_.touching_now(u.body, s.predicted->tick)) {
      u.has_state = u.release = false;
    }
    return !u.has_state && !u.release && chain_.held(u.body) == known_as_held;
  });
}

const Bundle& Reporter::finish(const Situation& s) {
  told_.avatar = avatar_;
  const bool last_word = avatar_ && avatar_->cause == Cause::kAtRest;
  const auto end = bodies_.begin() + static_cast<std::ptrdiff_t>(std::min(bodies_.size(), most_bodies_));
  told_.bodies.assign(bodies_.begin(), end);
  bodies_.erase(bodies_.begin(), end);
  for (BodyUpdate& u : told_.bodies) {
    u.held = chain_.held(u.body);
    if (u.has_state) u.state = s.live->world().state(u.body);
    if (u.has_state && u.cause == Cause::kAtRest) {  // at rest is exactly at rest
      u.state.awake = false;
      u.state.velocity = {};
      u.state.spin = 0;
    }
    const bool pressed = u.held && u.cause == Cause::kAtRest;  // moved a little, it would begin to move anew
    if (technique_.precision == Precision::kRounded && !last_word && !pressed) u.state = rounded(u.state);
  }
  return told_;
}

}  // namespace padr::sync
