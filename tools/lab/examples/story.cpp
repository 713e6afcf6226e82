#include "tools/lab/examples/story.h"

#include <algorithm>
#include <array>
#include <span>

#include "common/model/user_error.h"
#include "common/scenarios/bodies.h"
#include "common/scenarios/scenarios.h"

namespace padr::lab::examples {
namespace {

/// A leg of the avatar's way: to where, how fast its target moves, and how much of a take's sidestep applies there.
struct Leg {
  Vec2 to;      ///< m
  float speed;  ///< m/s
  float wait;   ///< s, there
  Vec2 aside;   ///< m, how far takes are shifted at the most
};

struct Script {
  const char* name;
  const char* scenario;
  const char* title;
  float seconds;
  Camera camera;
  std::span<const Leg> legs;
};

constexpr float kAside = 0.15F;   // m, that a take's approach is shifted by at the most
constexpr float kCloser = 0.1F;   // m, that a take's stop is nearer or farther by at the most
constexpr float kFaster = 0.15F;  // part of the speed, likewise

// The avatar's target runs ahead of it by a quarter of its speed: it cuts corners, and stops where its target stops.
// Stopping short: the gap that is left, 0.45 m, is wider than the low threshold and narrower than the high one. The
// avatar stays there for a while, and then goes back to where the run began, so that the path can be played in a loop.
// The way to the ball leads down to it at 40 degrees, as the ledge is too short for a run.
constexpr std::array<Leg, 3> kBallStop{{{{0.6F, 7.52F}, 2, 1, {0.096F, 0.115F}},
                                        {{1.966F, 6.373F}, 3, 4, {0.173F, 0.051F}},
                                        {{0.6F, 7.52F}, 2, 1, {0.096F, 0.115F}}}};
constexpr std::array<Leg, 3> kDominoesStop{
    {{{0.6F, 1.2F}, 2, 1, {0, kAside}}, {{2.55F, 1.2F}, 3, 4, {kCloser, kAside}}, {{0.6F, 1.2F}, 2, 1, {0, kAside}}}};
constexpr std::array<Leg, 3> kVanStop{
    {{{3, 7.5F}, 2, 1, {0, kAside}}, {{7.15F, 7.5F}, 3, 4, {kCloser, kAside}}, {{3, 7.5F}, 2, 1, {0, kAside}}}};

// The converse. The numbers were chosen on film: the turn is sharp and just short of the body, so that the touch is
// over before the threshold has told of the turn.
constexpr std::array<Leg, 6> kBallNudge{{{{1.2F, 8}, 3, 0, {0, 0}},
                                         {{1.75F, 8}, 3, 0.5F, {kAside, 0}},
                                         {{1.75F, 5.2F}, 4, 0, {kAside, 0}},
                                         {{2.7F, 5.5F}, 8, 0.15F, {0, 0}},
                                         {{1, 5.6F}, 6, 0, {0, 0}},
                                         {{1, 8}, 3, 0, {0, 0}}}};
constexpr std::array<Leg, 6> kDominoesKnock{{{{2.75F, 5}, 3, 0.5F, {kAside, 0}},
                                             {{2.75F, 1.25F}, 2.5F, 0, {kAside, 0}},
                                             {{3.8F, 1.2F}, 8, 0.05F, {0, 0}},
                                             {{2, 1.4F}, 6, 0, {0, 0}},
                                             {{2, 3}, 3, 0, {0, 0}},
                                             {{2, 3.5F}, 3, 0, {0, 0}}}};
constexpr std::array<Leg, 6> kVanBump{{{{7.3F, 12}, 3, 0.5F, {kAside, 0}},
                                       {{7.3F, 7.5F}, 4, 0, {kAside, 0}},
                                       {{8.7F, 7.5F}, 8, 0.15F, {0, 0}},
                                       {{6, 7.5F}, 6, 0, {0, 0}},
                                       {{3, 7.5F}, 3, 0, {0, 0}},
                                       {{2, 7.5F}, 3, 0, {0, 0}}}};
constexpr std::array<Leg, 6> kProxyPush{{{{4.8F, 12}, 3, 0.5F, {kAside, 0}},
                                         {{4.8F, 7.5F}, 4, 0, {kAside, 0}},
                                         {{7, 7.5F}, 8, 0.15F, {0, 0}},
                                         {{4, 7}, 6, 0, {0, 0}},
                                         {{3, 7.5F}, 3, 0, {0, 0}},
                                         {{2.5F, 7.5F}, 3, 0, {0, 0}}}};

constexpr Camera kSlope{{0, 0}, {20, 9}, {-0.25F, 0, 0.5F, 1.5F, 5}, ""};
constexpr Camera kRow{{0, 0}, {19, 5}, {-0.25F, 0, 1, 3, 6}, ""};
constexpr Camera kYard{{5, 4}, {15, 11}, {-0.25F, 0, 0.5F, 1, 4}, ""};
constexpr Camera kLine{{2, 5}, {14, 11}, {-0.25F, 0, 0.5F, 1, 4}, "ABC"};

constexpr std::array<Script, 9> kScripts{{
    {"ball", "ball", "an avatar stops short of a ball above a slope; its model runs on", 16, kSlope, kBallStop},
    {"dominoes", "dominoes", "an avatar stops short of a row of dominoes; its model runs on", 16, kRow, kDominoesStop},
    {"van", "van", "an avatar stops short of a van of 2.5 t; its model runs on", 16, kYard, kVanStop},
    {"carton", "van", "the same stop short of a carton of the van's size but 25 kg", 16, kYard, kVanStop},
    {"proxy", "proxy", "an avatar pushes A into B and B into C", 16, kLine, kProxyPush},
    {"ball-missed", "ball", "an avatar nudges the ball over the edge; its model misses it", 16, kSlope, kBallNudge},
    {"dominoes-missed", "dominoes", "an avatar knocks the first domino over; its model misses it", 16, kRow,
     kDominoesKnock},
    {"van-missed", "van", "an avatar bumps into the van; its model misses it", 16, kYard, kVanBump},
    {"carton-missed", "van", "the same bump into the carton of 25 kg", 16, kYard, kVanBump},
}};

const Script& script_of(const std::string& name) {
  std::string known;
  for (const Script& s : kScripts) {
    if (s.name == name) return s;
    known += (known.empty() ? "" : ", ") + std::string(s.name);
  }
  throw UserError("--stories: '" + name + "' is not allowed; give some of " + known);
}

/// The n-th number of van der Corput's sequence, 0 .. 1: evenly spread whatever n is.
float spread(int n, int base) {
  float value = 0;
  float digit = 1;
  for (; n > 0; n /= base) {
    digit /= static_cast<float>(base);
    value += digit * static_cast<float>(n % base);
  }
  return value;
}

Scene scene_of(const Script& s, int dominoes) {
  const std::string file = std::string(s.scenario) + ".textproto";
  std::string text(scenarios::embedded_text(s.scenario));
  if (s.scenario == std::string("dominoes"))
    text = scenarios::with_bodies(text, file, static_cast<std::uint32_t>(dominoes));
  Scene scene = scenarios::load(text, file, 1);
  if (std::string(s.name).starts_with("carton")) scene.bodies.front().mass = 25;
  return scene;
}

}  // namespace

std::vector<std::string> story_names() {
  std::vector<std::string> names;
  names.reserve(kScripts.size());
  for (const Script& s : kScripts) names.emplace_back(s.name);
  return names;
}

Story story_by_name(const std::string& name, int dominoes) {
  const Script& s = script_of(name);
  return {s.name, s.scenario, s.title, scene_of(s, dominoes), s.seconds, s.camera};
}

scenarios::Path path_of(const Story& story, int take) {
  const float aside = take == 0 ? 0 : 2 * spread(take, 2) - 1;
  const float faster = take == 0 ? 0 : 2 * spread(take, 3) - 1;
  std::vector<scenarios::PathPoint> points;
  Vec2 at = story.scene.avatar.spawns.front();
  points.push_back({0, at});
  points.push_back({1, at});
  double seconds = 1;
  for (const Leg& leg : script_of(story.name).legs) {
    const Vec2 to = leg.to + leg.aside * aside;
    const float speed = leg.speed * (1 + kFaster * faster);
    if (distance(at, to) > 0) points.push_back({seconds += static_cast<double>(distance(at, to) / speed), to});
    if (leg.wait > 0) points.push_back({seconds += static_cast<double>(leg.wait), to});
    at = to;
  }
  return scenarios::Path(std::move(points));
}

}  // namespace padr::lab::examples
