#include "tools/lab/examples/film.h"

#include <algorithm>
#include <cmath>

#include "shell/text.h"

namespace padr::lab::examples {
namespace {

using plot::Role;

std::string metres(double v) {
  return shell::fixed(v, v < 10 ? 2 : 1) + " m";
}

std::string column(float seconds, bool touches) {
  if (seconds == 0) return touches ? "first touch" : "the model hits";
  return plot::number(std::abs(static_cast<double>(seconds))) + " s " + (seconds < 0 ? "before" : "after");
}

/// Collects the frames of two rows, truth and belief, while a story is played.
class Camerawork {
 public:
  Camerawork(const Story& story, Tick moment) : story_(story) {
    for (const float s : story.camera.frames)
      when_.push_back(std::max<Tick>(1, moment + static_cast<Tick>(std::lround(s * kTicksPerSecond))));
    avatar_.radius = story.scene.avatar.radius;
  }

  void look(const Moment& m) {
    const std::size_t walker = story_.scene.bodies.size();
    // Where it came from is of interest for a second only: the turn.
    constexpr std::size_t kTrail = kTicksPerSecond;
    walked_.push_back(m.truth[walker].position);
    modelled_.push_back(m.believed[walker].position);
    if (walked_.size() > kTrail) walked_.erase(walked_.begin());
    if (modelled_.size() > kTrail) modelled_.erase(modelled_.begin());
    if (std::find(when_.begin(), when_.end(), m.tick) == when_.end()) return;
    truth.push_back(frame_of_truth(m, walker));
    belief.push_back(frame_of_belief(m, walker));
  }

  std::vector<plot::Frame> truth;
  std::vector<plot::Frame> belief;

 private:
  std::string letter(std::size_t body) const {
    return body < story_.camera.letters.size() ? std::string(story_.camera.letters.substr(body, 1)) : "";
  }

  plot::Frame frame_of_truth(const Moment& m, std::size_t walker) const {
    plot::Frame f;
    f.trails.push_back({walked_, Role::kAvatar});
    for (std::size_t b = 0; b < walker; ++b)
      f.things.push_back({story_.scene.bodies[b], m.truth[b].position, m.truth[b].angle, Role::kBody, letter(b)});
    f.things.push_back({avatar_, m.truth[walker].position, 0, Role::kAvatar, {}});
    return f;
  }

  plot::Frame frame_of_belief(const Moment& m, std::size_t walker) const {
    plot::Frame f;
    f.trails.push_back({modelled_, Role::kModel});
    double off = 0;
    for (std::size_t b = 0; b < walker; ++b) {
      const float error = distance(m.truth[b].position, m.believed[b].position);
      off += static_cast<double>(error);
      const bool disturbed = error > kDisturbedMetres;
      f.things.push_back({story_.scene.bodies[b], m.believed[b].position, m.believed[b].angle,
                          disturbed ? Role::kDisturbed : Role::kBody, letter(b)});
      if (disturbed)
        f.things.push_back({story_.scene.bodies[b], m.truth[b].position, m.truth[b].angle, Role::kOutline, {}});
    }
    f.things.push_back({avatar_, m.believed[walker].position, 0, Role::kModel, {}});
    f.things.push_back({avatar_, m.truth[walker].position, 0, Role::kOutline, {}});
    f.note = "bodies off by " + metres(off);
    return f;
  }

  const Story& story_;
  BodyDef avatar_;
  std::vector<Tick> when_;
  std::vector<Vec2> walked_;
  std::vector<Vec2> modelled_;
};

}  // namespace

plot::FilmStrip film_of(const Story& story, const std::vector<std::pair<std::string, Technique>>& techniques,
                        const link::NetemSpec& netem) {
  plot::FilmStrip film;
  film.name = "film-" + story.name;
  film.title = story.name + ": " + story.title;
  film.scene = story.scene;
  film.lower = story.camera.lower;
  film.upper = story.camera.upper;
  const TrueStory truth = true_story(story, 0);
  const bool touches = truth.touched >= 0;
  const Tick moment = moment_of(story, 0, truth, netem);
  for (const float s : story.camera.frames) film.columns.push_back(column(s, touches));
  for (const auto& [name, technique] : techniques) {
    Camerawork camera(story, moment);
    const Cost cost = measure(story, 0, truth, technique, netem, [&camera](const Moment& m) { camera.look(m); });
    if (film.rows.empty())
      film.rows.push_back({"Peer 0, whose avatar it is",
                           touches ? "what it sees is what happens"
                                   : "it stops " + metres(truth.nearest_m) + " short and touches nothing",
                           std::move(camera.truth)});
    film.rows.push_back({"Peer 1, " + name,
                         "bodies off by " + metres(cost.peak_m) + " at worst, " + metres(cost.final_m) +
                             " in the end; bodies disturbed: " + plot::number(cost.ever) + " of " +
                             std::to_string(story.scene.bodies.size()) + ", for good " + plot::number(cost.at_end),
                         std::move(camera.belief)});
  }
  film.key = {{Role::kAvatar, "avatar"},
              {Role::kModel, "its model at peer 1"},
              {Role::kBody, "body"},
              {Role::kDisturbed, "body more than 5 cm off"},
              {Role::kOutline, "where it is for peer 0"}};
  return film;
}

}  // namespace padr::lab::examples
