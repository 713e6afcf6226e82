#include "tools/lab/figures/claims.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "tools/lab/figures/words.h"

namespace padr::lab::figures {
namespace {

// Numbers of one run, as over_cases takes them.
double first_third(const Measures& m) {
  return m.thirds_m[0];
}
double second_third(const Measures& m) {
  return m.thirds_m[1];
}
double last_third(const Measures& m) {
  return m.thirds_m[2];
}
double combined_mean(const Measures& m) {
  return m.combined.mean_m;
}
double trend(const Measures& m) {
  return m.trend_m_per_min;
}
double free_within(const Measures& m) {
  return m.free_within_share;
}
double within(const Measures& m) {
  return m.within_share;
}
double longest_above(const Measures& m) {
  return m.above_longest_s;
}
double peak(const Measures& m) {
  return m.combined.peak_m;
}
double peak_touching(const Measures& m) {
  return m.peak_touching ? 1 : 0;
}
double avatar_peak(const Measures& m) {
  return m.avatar_peak_m;
}
double body_peak(const Measures& m) {
  return m.body_peak_m;
}
double updates(const Measures& m) {
  return m.updates_per_min;
}

const std::string kAdaptive = adaptive_id(kPredictors[0]);

/// The question one claim asks, of numbers of one case and of their means alike: three numbers, in order.
using Question = bool (*)(double, double, double);

bool rises(double a, double b, double c) {
  return a < b && b < c;
}
bool falls(double a, double b, double c) {
  return a > b && b > c;
}
bool more_than_half(double share, double, double) {
  return share > 0.5;
}
bool at_most(double a, double b, double) {
  return a <= b;
}
/// Whether b is nearer to c than to a, a and c being ends of a range.
bool nearer_to_last(double a, double b, double c) {
  return std::abs(b - c) < std::abs(b - a);
}

struct Asker {
  const Plan& plan;
  const Results& results;

  std::vector<double> of(const std::string& setting, double (*number)(const Measures&)) const {
    return over_cases(plan, results, setting, number);
  }
  double mean(const std::string& setting, double (*number)(const Measures&)) const {
    return mean_of(of(setting, number));
  }
  /// Adds to what the claim says of how often and on average; on average holds only if it does every time it is asked.
  void ask(Claim& c, Question question, const std::vector<double>& first, const std::vector<double>& second,
           const std::vector<double>& third) const {
    const bool average = question(mean_of(first), mean_of(second), mean_of(third));
    c.on_average = (c.of == 0 || c.on_average) && average;
    for (std::size_t i = 0; i < first.size(); ++i) {
      const bool holds = question(first[i], second[i], third[i]);
      Claim::Share& share = c.by_kind[plan.cases[i].kind];
      c.holds_in += holds ? 1 : 0;
      share.holds_in += holds ? 1 : 0;
      ++share.of;
    }
    c.of += static_cast<int>(first.size());
  }
  /// "a, b and c": a mean at each of the paper's thresholds.
  std::string at_thresholds(const std::string& name, double (*number)(const Measures&), int digits) const {
    return fixed(mean(name + "-0.8", number), digits) + ", " + fixed(mean(name + "-0.5", number), digits) + " and " +
           fixed(mean(name + "-0.3", number), digits);
  }
  void ask_thresholds(Claim& c, Question question, double (*number)(const Measures&)) const {
    ask(c, question, of("fixed-0.8", number), of("fixed-0.5", number), of("fixed-0.3", number));
  }
  /// Asks a share at each of the paper's thresholds by itself; the means, as at_thresholds has them.
  std::string ask_shares(Claim& c, Question question, double (*number)(const Measures&)) const {
    std::string shares;
    for (const char* t : kThresholds) {
      const std::vector<double> share = of(std::string("fixed-") + t, number);
      ask(c, question, share, share, share);
      shares += (shares.empty() ? "" : (t == kThresholds.back() ? " and " : ", ")) + percent(mean_of(share));
    }
    return shares;
  }
};

Claim growth(const Asker& a) {
  Claim c{.id = "grows-without-authority", .figure = "7"};
  c.says =
      "Without authority over bodies the worlds drift apart: what one peer's avatar pushes, the other's never learns "
      "of, "
      "so inconsistency piles up and no threshold prevents it.";
  c.test = "the mean of each third of the run is above that of the third before, at each threshold";
  for (const char* t : kThresholds) {
    const std::string id = std::string("avatar-only-") + t;
    a.ask(c, rises, a.of(id, first_third), a.of(id, second_third), a.of(id, last_third));
  }
  c.measured = "At 0.8, 0.5 and 0.3 m it grows by " + a.at_thresholds("avatar-only", trend, 0) +
               " m a minute, and is " + a.at_thresholds("avatar-only", last_third, 0) +
               " m in the mean of the last third of the run.";
  return c;
}

Claim bounded(const Asker& a) {
  Claim c{.id = "bounded-with-authority", .figure = "8"};
  c.says = "With dynamic authority inconsistency is bounded: it rises at collisions and comes back.";
  c.test =
      "while the avatar touches nothing, combined inconsistency is within the threshold, and the way of a tick, at 95 "
      "% "
      "of the ticks, at each threshold";
  const auto enough = [](double share, double, double) { return share >= 0.95; };
  const std::string shares = a.ask_shares(c, enough, free_within);
  c.measured = "At 0.8, 0.5 and 0.3 m it is within the threshold at " + shares +
               " of the ticks without contact; over the whole run the mean is " +
               a.at_thresholds("fixed", combined_mean, 2) + " m, over its last third " +
               a.at_thresholds("fixed", last_third, 2) + " m, against " +
               a.at_thresholds("avatar-only", last_third, 0) + " m without authority. The longest time above the " +
               "threshold is " + a.at_thresholds("fixed", longest_above, 1) + " s, against " +
               a.at_thresholds("avatar-only", longest_above, 0) + " s.";
  return c;
}

/// What an avatar makes in two ticks comes on top: an update says where it is at the end of a tick, and takes one more.
double avatar_limit_m(const Asker& a, const char* threshold) {
  double fastest = 0;
  for (const Case& c : a.plan.cases) fastest = std::max(fastest, static_cast<double>(c.scene.avatar.max_speed));
  return std::stod(threshold) + 2 * fastest / kTicksPerSecond;
}

Claim mostly_within(const Asker& a) {
  Claim c{.id = "mostly-within-threshold", .figure = "8"};
  c.says = "Most of the time inconsistency is within the threshold.";
  c.test =
      "combined inconsistency is within the threshold, and the way of a tick, at more than half of all ticks, at each "
      "threshold";
  c.measured = "At 0.8, 0.5 and 0.3 m it is within the threshold at " + a.ask_shares(c, more_than_half, within) +
               " of all ticks.";
  return c;
}

Claim avatar_within(const Asker& a) {
  Claim c{.id = "avatar-within-threshold", .figure = "8"};
  c.says = "Without latency the avatar's own error stays within the threshold.";
  c.test =
      "the avatar's error is at most the threshold and its way of two ticks, which an update takes here, at each "
      "threshold";
  for (const char* t : kThresholds) {
    const std::vector<double> peaks = a.of(std::string("fixed-") + t, avatar_peak);
    const std::vector<double> limit(peaks.size(), avatar_limit_m(a, t));
    a.ask(c, at_most, peaks, limit, limit);
  }
  c.measured = "At 0.8, 0.5 and 0.3 m avatars are off by up to " + a.at_thresholds("fixed", avatar_peak, 2) + " m.";
  return c;
}

Claim smaller_peaks(const Asker& a) {
  Claim c{.id = "tighter-smaller-peaks", .figure = "8"};
  c.says = "The tighter the threshold, the smaller the peaks.";
  c.test = "the peak of combined inconsistency falls from 0.8 to 0.5 to 0.3 m";
  a.ask_thresholds(c, falls, peak);
  c.measured = "At 0.8, 0.5 and 0.3 m peaks are " + a.at_thresholds("fixed", peak, 2) + " m, of which avatars up to " +
               a.at_thresholds("fixed", avatar_peak, 2) + " m and bodies up to " +
               a.at_thresholds("fixed", body_peak, 2) + " m. The avatar was touching a body when the peak came in " +
               percent((a.mean("fixed-0.8", peak_touching) + a.mean("fixed-0.5", peak_touching) +
                        a.mean("fixed-0.3", peak_touching)) /
                       3) +
               " of the runs.";
  return c;
}

Claim smaller_body_peaks(const Asker& a) {
  Claim c{.id = "tighter-smaller-bodies", .figure = "8"};
  c.says = "The tighter the threshold, the less bodies are off at collisions.";
  c.test = "the peak of the bodies' part falls from 0.8 to 0.5 to 0.3 m";
  a.ask_thresholds(c, falls, body_peak);
  c.measured = "At 0.8, 0.5 and 0.3 m bodies alone peak at " + a.at_thresholds("fixed", body_peak, 2) + " m.";
  return c;
}

Claim more_updates(const Asker& a) {
  Claim c{.id = "tighter-more-updates", .figure = "8"};
  c.says = "That is paid for with updates; the paper does not say with how many.";
  c.test = "the number of entity updates rises from 0.8 to 0.5 to 0.3 m";
  a.ask_thresholds(c, rises, updates);
  c.measured = "At 0.8, 0.5 and 0.3 m there are " + a.at_thresholds("fixed", updates, 0) + " updates a minute.";
  return c;
}

Claim adaptive_mostly_within(const Asker& a) {
  Claim c{.id = "adaptive-mostly-within", .figure = "9"};
  c.says = "With a threshold that goes from 0.8 to 0.3 m inconsistency is mostly within 0.8 m.";
  c.test = "combined inconsistency is within 0.8 m, and the way of a tick, at more than half of all ticks";
  const std::vector<double> share = a.of(kAdaptive, within);
  a.ask(c, more_than_half, share, share, share);
  c.measured = "It is within 0.8 m at " + percent(mean_of(share)) + " of all ticks.";
  return c;
}

Claim adaptive_peaks(const Asker& a) {
  Claim c{.id = "adaptive-peaks", .figure = "9"};
  c.says = "A threshold that goes from 0.8 to 0.3 m when interaction is predicted has about the peaks of 0.3 m.";
  c.test = "the peak of combined inconsistency is nearer to that of fixed 0.3 m than to that of fixed 0.8 m";
  a.ask(c, nearer_to_last, a.of("fixed-0.8", peak), a.of(kAdaptive, peak), a.of("fixed-0.3", peak));
  c.measured = "Peaks are " + fixed(a.mean(kAdaptive, peak), 2) + " m with the adaptive threshold, " +
               fixed(a.mean("fixed-0.3", peak), 2) + " m with 0.3 m and " + fixed(a.mean("fixed-0.8", peak), 2) +
               " m with 0.8 m. Away from bodies the avatar may be off by 0.8 m, and is: up to " +
               fixed(a.mean(kAdaptive, avatar_peak), 2) + " m, which is the peak where bodies stay below that.";
  return c;
}

Claim adaptive_body_peaks(const Asker& a) {
  Claim c{.id = "adaptive-body-peaks", .figure = "9"};
  c.says = "The same of what it is for: what the avatar's error does to bodies.";
  c.test = "the peak of the bodies' part is nearer to that of fixed 0.3 m than to that of fixed 0.8 m";
  a.ask(c, nearer_to_last, a.of("fixed-0.8", body_peak), a.of(kAdaptive, body_peak), a.of("fixed-0.3", body_peak));
  c.measured = "Bodies alone peak at " + fixed(a.mean(kAdaptive, body_peak), 2) + " m with the adaptive threshold, " +
               fixed(a.mean("fixed-0.3", body_peak), 2) + " m with 0.3 m and " +
               fixed(a.mean("fixed-0.8", body_peak), 2) + " m with 0.8 m.";
  return c;
}

Claim adaptive_updates(const Asker& a) {
  Claim c{.id = "adaptive-updates", .figure = "9"};
  c.says =
      "What it is for (sections V.b and VI): fewer updates than with 0.3 m all the time. The paper does not say how "
      "many.";
  c.test = "the number of entity updates is between those of fixed 0.8 m and fixed 0.3 m";
  a.ask(c, rises, a.of("fixed-0.8", updates), a.of(kAdaptive, updates), a.of("fixed-0.3", updates));
  c.measured = fixed(a.mean(kAdaptive, updates), 0) + " updates a minute against " +
               fixed(a.mean("fixed-0.3", updates), 0) + " with 0.3 m and " + fixed(a.mean("fixed-0.8", updates), 0) +
               " with 0.8 m. Most of them are about contacts and bodies, which no threshold saves.";
  return c;
}

}  // namespace

std::string share_text(const Claim& c) {
  std::string s = std::to_string(c.holds_in) + " of " + std::to_string(c.of);
  if (c.by_kind.size() < 2) return s;
  std::string kinds;
  for (const auto& [kind, share] : c.by_kind)
    kinds +=
        (kinds.empty() ? "" : ", ") + kind + " " + std::to_string(share.holds_in) + " of " + std::to_string(share.of);
  return s + " (" + kinds + ")";
}

std::vector<Claim> judge_claims(const Plan& plan, const Results& results) {
  const Asker a{plan, results};
  return {growth(a),          bounded(a),
          mostly_within(a),   avatar_within(a),
          smaller_peaks(a),   smaller_body_peaks(a),
          more_updates(a),    adaptive_mostly_within(a),
          adaptive_peaks(a),  adaptive_body_peaks(a),
          adaptive_updates(a)};
}

}  // namespace padr::lab::figures
