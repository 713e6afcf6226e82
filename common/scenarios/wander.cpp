#include "common/scenarios/wander.h"

#include <algorithm>
#include <cmath>

#include "common/model/portable_math.h"
#include "common/model/rng.h"

namespace padr::scenarios {
namespace {

// Names this use of the seed, so that other users of it draw other numbers.
constexpr std::uint64_t kWanderStream = 0x3A4DE2;
// Fitts's law with values usual for a mouse: seconds, and seconds per bit.
constexpr double kFittsStart = 0.15;
constexpr double kFittsPerBit = 0.2;
// Metres: how exactly goals are aimed at.
constexpr double kSmallGoal = 0.3;
constexpr double kLargeGoal = 1.2;
// A pause follows most reaches; the others flow into the next.
constexpr double kPauseChance = 0.7;
constexpr double kShortestPause = 0.1;  // s
constexpr double kLongestPause = 1.2;   // s
constexpr double kMostBow = 0.08;
// Peak of the minimum-jerk speed profile relative to its mean.
constexpr double kPeakToMean = 1.875;
// A chapter is a minute, longer where the play area is so large that reaches take long.
constexpr Tick kShortestChapter = 60 * kTicksPerSecond;
constexpr int kGoalsTried = 20;

Tick ticks(double seconds) {
  return std::max(1, static_cast<Tick>(std::ceil(seconds * kTicksPerSecond)));
}

}  // namespace

WanderOptions wander_options(const Scene& scene, int slot) {
  WanderOptions options;
  options.lower = scene.lower;
  options.upper = scene.upper;
  options.start = scene.avatar.spawns.at(static_cast<std::size_t>(slot));
  options.margin = scene.avatar.radius + 0.3F;
  options.peak_speed = 0.9F * scene.avatar.max_speed;
  options.slot = slot;
  return options;
}

Wander::Wander(const WanderOptions& options, std::uint64_t seed)
    : options_(options), seed_(derive_seed(seed, kWanderStream, static_cast<std::uint64_t>(options.slot))) {
  // Room for the longest reach three times, so that every plan has some choice.
  const Tick longest = reach_ticks(options_.lower, options_.upper, kSmallGoal);
  chapter_ticks_ = std::max(kShortestChapter, 3 * longest + 2 * ticks(kLongestPause));
}

Vec2 Wander::target(Tick tick) {
  tick = std::max(tick, 0);
  if (const std::int64_t chapter = tick / chapter_ticks_; chapter != planned_) plan(chapter);
  tick %= chapter_ticks_;
  const auto after = std::upper_bound(reaches_.begin(), reaches_.end(), tick,
                                      [](Tick t, const Reach& reach) { return t < reach.begin; });
  return after == reaches_.begin() ? reaches_.front().from : on_reach(*std::prev(after), tick);
}

Vec2 Wander::anchor(std::int64_t number) const {
  return number == 0 ? options_.start : random_point(derive_seed(seed_, 1, static_cast<std::uint64_t>(number)));
}

Vec2 Wander::random_point(std::uint64_t stream_seed) const {
  Rng rng(stream_seed);
  const auto along = [&](float low, float high) {
    const double inset = std::min(static_cast<double>(options_.margin), static_cast<double>(high - low) / 4);
    return static_cast<float>(rng.uniform(low + inset, high - inset));
  };
  const float x = along(options_.lower.x, options_.upper.x);
  return {x, along(options_.lower.y, options_.upper.y)};
}

Tick Wander::reach_ticks(Vec2 from, Vec2 to, double goal_size) const {
  const double d = distance(from, to);
  const double fitts = kFittsStart + kFittsPerBit * binary_logarithm(d / goal_size + 1);
  return ticks(std::max(fitts, kPeakToMean * d / static_cast<double>(options_.peak_speed)));
}

void Wander::plan(std::int64_t number) {
  planned_ = number;
  reaches_.clear();
  Rng rng(derive_seed(seed_, 2, static_cast<std::uint64_t>(number)));
  const Vec2 home = anchor(number + 1);
  Vec2 position = anchor(number);
  Tick now = ticks(rng.uniform(kShortestPause, kLongestPause));
  // Always leaves time to get to where the next chapter begins. Towards the end few goals do: a few are tried, or the
  // chapter would end with a long wait.
  for (int refused = 0; refused < kGoalsTried;) {
    const Vec2 goal = random_point(rng.next_u64());
    const Tick end = now + reach_ticks(position, goal, rng.uniform(kSmallGoal, kLargeGoal));
    const double bow = rng.uniform(-kMostBow, kMostBow);
    const Tick next = end + (rng.chance(kPauseChance) ? ticks(rng.uniform(kShortestPause, kLongestPause)) : 0);
    if (next + reach_ticks(goal, home, kSmallGoal) > chapter_ticks_) {
      ++refused;
      continue;
    }
    reaches_.push_back({now, end, position, goal, bow});
    position = goal;
    now = next;
    refused = 0;
  }
  reaches_.push_back({now, now + reach_ticks(position, home, kSmallGoal), position, home, 0});
}

Vec2 Wander::on_reach(const Reach& reach, Tick tick) const {
  if (tick >= reach.end) return reach.to;
  const double u = static_cast<double>(tick - reach.begin) / static_cast<double>(reach.end - reach.begin);
  const double along = u * u * u * (10 + u * (6 * u - 15));
  // Rises and falls as smoothly as the reach itself, and is level where the reach is fastest.
  const double bump = 4 * u * (1 - u);
  const double aside = reach.bow * bump * bump * bump;
  const double dx = static_cast<double>(reach.to.x) - static_cast<double>(reach.from.x);
  const double dy = static_cast<double>(reach.to.y) - static_cast<double>(reach.from.y);
  const Vec2 p{static_cast<float>(static_cast<double>(reach.from.x) + along * dx - aside * dy),
               static_cast<float>(static_cast<double>(reach.from.y) + along * dy + aside * dx)};
  return {std::clamp(p.x, options_.lower.x, options_.upper.x), std::clamp(p.y, options_.lower.y, options_.upper.y)};
}

}  // namespace padr::scenarios
