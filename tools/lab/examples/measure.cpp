#include "tools/lab/examples/measure.h"

#include <algorithm>
#include <cmath>

#include "tools/lab/examples/variant.h"
#include "tools/lab/simulation.h"

namespace padr::lab::examples {
namespace {

/// The path, and then its end.
class Walk : public scenarios::InputSource {
 public:
  explicit Walk(scenarios::Path path) : path_(std::move(path)) {}
  Vec2 target(Tick tick) override { return path_.at(static_cast<double>(tick) / kTicksPerSecond, false); }

 private:
  scenarios::Path path_;
};

class Stay : public scenarios::InputSource {
 public:
  explicit Stay(Vec2 where) : where_(where) {}
  Vec2 target(Tick /*tick*/) override { return where_; }

 private:
  Vec2 where_;
};

/// Everything rests before it is touched.
bool something_moves(const world::View& w) {
  constexpr float kMoves = 0.02F;  // m/s
  for (EntityId b = 0; b < w.bodies(); ++b)
    if (length(w.velocity(b)) > kMoves) return true;
  return false;
}

/// Between the first avatar and a body, m; 0 or less where they touch.
float gap(const world::View& w, EntityId b) {
  const BodyDef& d = w.scene().bodies[b];
  const BodyState body = w.state(b);
  const Vec2 off = w.position(w.avatar(0)) - body.position;
  const float avatar = w.scene().avatar.radius;
  if (d.shape == ShapeKind::kCircle) return length(off) - d.radius - avatar;
  const float c = std::cos(body.angle);
  const float s = std::sin(body.angle);
  const Vec2 own{std::abs(off.x * c + off.y * s), std::abs(off.y * c - off.x * s)};
  return length({std::max(0.0F, own.x - d.half.x), std::max(0.0F, own.y - d.half.y)}) - avatar;
}

float least_gap(const world::View& w) {
  float least = gap(w, 0);
  for (EntityId b = 1; b < w.bodies(); ++b) least = std::min(least, gap(w, b));
  return least;
}

/// A touch can be over within the step that it begins in: what it has set in motion shows it then.
bool touched(const world::View& w) {
  constexpr float kSkin = 0.01F;  // m, at which Box2D lets a circle rest on a box
  return something_moves(w) || least_gap(w) <= kSkin;
}

/// Folds ticks into a Cost.
class Costing {
 public:
  explicit Costing(const TrueStory& story, std::size_t bodies) : story_(story), disturbed_(bodies, false) {
    cost_.final_by_body_m.resize(bodies);
    cost_.course.touched = story.touched;
    cost_.course.nearest_m = story.nearest_m;
  }

  void tick(const world::View& truth, const world::View& believed, Tick now) {
    compare_views(truth, believed);
    compare_with_story(believed, story_.bodies[static_cast<std::size_t>(now - 1)]);
    const EntityId avatar = truth.avatar(0);
    const auto astray = static_cast<double>(distance(truth.position(avatar), believed.position(avatar)));
    cost_.avatar_mean_m += astray;
    cost_.avatar_peak_m = std::max(cost_.avatar_peak_m, astray);
    Course& c = cost_.course;
    if (c.hit < 0 && (c.touched < 0 || now < c.touched) && something_moves(believed)) c.hit = now;
    ++ticks_;
  }

  void warned(Tick now) {
    if (cost_.course.warned < 0) cost_.course.warned = now;
  }

  Cost result() {
    cost_.area_ms = cost_.mean_m / kTicksPerSecond;
    cost_.mean_m /= ticks_;
    cost_.untrue_mean_m /= ticks_;
    cost_.avatar_mean_m /= ticks_;
    cost_.ever = static_cast<double>(std::count(disturbed_.begin(), disturbed_.end(), true));
    return cost_;
  }

 private:
  void compare_views(const world::View& truth, const world::View& believed) {
    cost_.final_m = 0;
    cost_.at_end = 0;
    for (std::size_t b = 0; b < disturbed_.size(); ++b) {
      const auto e = static_cast<EntityId>(b);
      const float off = distance(truth.position(e), believed.position(e));
      const bool disturbed = off > kDisturbedMetres;
      disturbed_[b] = disturbed_[b] || disturbed;
      cost_.at_end += disturbed ? 1 : 0;
      cost_.final_by_body_m[b] = static_cast<double>(off);
      cost_.final_m += static_cast<double>(off);
    }
    cost_.mean_m += cost_.final_m;
    cost_.peak_m = std::max(cost_.peak_m, cost_.final_m);
  }

  void compare_with_story(const world::View& believed, const std::vector<Vec2>& bodies) {
    cost_.untrue_final_m = 0;
    cost_.untrue_at_end = 0;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const float off = distance(believed.position(static_cast<EntityId>(b)), bodies[b]);
      cost_.untrue_at_end += off > kDisturbedMetres ? 1 : 0;
      cost_.untrue_final_m += static_cast<double>(off);
    }
    cost_.untrue_mean_m += cost_.untrue_final_m;
  }

  const TrueStory& story_;
  Cost cost_;
  std::vector<bool> disturbed_;
  double ticks_ = 0;
};

std::vector<BodyState> states_of(const world::View& w) {
  std::vector<BodyState> states;
  for (EntityId e = 0; e < w.entities(); ++e) states.push_back(w.state(e));
  return states;
}

/// A session of two on a story: peer 0's avatar walks, peer 1's stays.
class Play {
 public:
  Play(const Story& story, int take, const Technique& technique, const link::NetemSpec& netem)
      : walk_(path_of(story, take)),
        stay_(story.scene.avatar.spawns[1]),
        simulation_(config(story, take, technique, netem)) {}

  Simulation& simulation() { return simulation_; }
  const world::View& truth() const { return simulation_.replica(0).live().world(); }
  const world::View& believed() const { return simulation_.replica(1).live().world(); }

 private:
  SimulationConfig config(const Story& story, int take, const Technique& technique, const link::NetemSpec& netem) {
    SimulationConfig c;
    c.scene = story.scene;
    c.technique = technique;
    c.netem = netem;
    c.netem_seed = static_cast<std::uint64_t>(take) + 1;
    c.inputs = {&walk_, &stay_};
    c.ticks = static_cast<Tick>(std::lround(story.seconds * kTicksPerSecond));
    return c;
  }

  Walk walk_;
  Stay stay_;
  Simulation simulation_;
};

}  // namespace

TrueStory true_story(const Story& story, int take) {
  // Without authority every peer plays bodies out by itself, and nobody but the walking avatar comes near them.
  Play play(story, take, technique_by_name("avatar-only"), {});
  TrueStory t;
  play.simulation().run([&](Tick now) {
    std::vector<Vec2> bodies;
    for (EntityId b = 0; b < play.truth().bodies(); ++b) bodies.push_back(play.truth().position(b));
    t.bodies.push_back(std::move(bodies));
    if (t.touched < 0 && touched(play.truth())) t.touched = now;
    const double gap = std::max(0.0F, least_gap(play.truth()));
    if (t.nearest >= 0 && gap >= t.nearest_m) return;
    t.nearest = now;
    t.nearest_m = gap;
  });
  if (t.touched >= 0) t.nearest_m = 0;
  return t;
}

Cost measure(const Story& story, int take, const TrueStory& truth, const Technique& technique,
             const link::NetemSpec& netem, const std::function<void(const Moment&)>& on_tick) {
  Play play(story, take, technique, netem);
  Costing costing(truth, story.scene.bodies.size());
  play.simulation().run([&](Tick now) {
    costing.tick(play.truth(), play.believed(), now);
    if (play.simulation().replica(0).prediction().interaction) costing.warned(now);
    if (on_tick) on_tick({now, states_of(play.truth()), states_of(play.believed())});
  });
  Cost cost = costing.result();
  const node::ReplicaStats& stats = play.simulation().replica(0).stats();
  for (const std::uint64_t n : stats.updates_by_cause) cost.updates += static_cast<double>(n);
  cost.kbit = static_cast<double>(stats.wire_bytes_sent) * 8 / 1000;
  return cost;
}

Tick moment_of(const Story& story, int take, const TrueStory& truth, const link::NetemSpec& netem) {
  if (truth.touched >= 0) return truth.touched;
  const Tick hit = measure(story, take, truth, without_authority().technique, netem).course.hit;
  return hit >= 0 ? hit : truth.nearest;
}

Cost mean_of(const std::vector<Cost>& takes) {
  Cost m;
  const auto n = static_cast<double>(takes.size());
  for (const Cost& c : takes) {
    m.mean_m += c.mean_m / n;
    m.peak_m += c.peak_m / n;
    m.final_m += c.final_m / n;
    m.area_ms += c.area_ms / n;
    m.ever += c.ever / n;
    m.at_end += c.at_end / n;
    m.avatar_mean_m += c.avatar_mean_m / n;
    m.avatar_peak_m += c.avatar_peak_m / n;
    m.updates += c.updates / n;
    m.kbit += c.kbit / n;
    m.untrue_mean_m += c.untrue_mean_m / n;
    m.untrue_final_m += c.untrue_final_m / n;
    m.untrue_at_end += c.untrue_at_end / n;
    m.final_by_body_m.resize(c.final_by_body_m.size());
    for (std::size_t b = 0; b < c.final_by_body_m.size(); ++b) m.final_by_body_m[b] += c.final_by_body_m[b] / n;
  }
  return m;
}

}  // namespace padr::lab::examples
