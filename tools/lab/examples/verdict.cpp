#include "tools/lab/examples/verdict.h"

#include <fmt/printf.h>

#include <cassert>

namespace padr::lab::examples {
namespace {

/// What comes first without a predictor: the model's hit or the true contact; -1: neither.
Tick event_of(const Course& without) {
  return without.hit >= 0 ? without.hit : without.touched;
}

/// A predictor sees what it looks at: the reason for its warnings, or for their absence.
std::string reason(const Verdict& v, const Technique& t) {
  const bool warned = v.warned > 0;
  switch (t.predictor) {
    case Predictor::kNone:
      return {};
    case Predictor::kLookahead:
      if (v.contacts == 0)
        return warned ? "It steps a copy from the avatar's true state. It expected a contact that never came."
                      : "It steps a copy from the avatar's true state. That copy touches nothing, so it cannot warn.";
      return warned ? "It steps a copy from the avatar's true state. That copy does touch a body."
                    : "It steps a copy from the avatar's true state. It saw the contact only when it was there.";
    case Predictor::kPcc:
      if (!warned)
        return fmt::sprintf(
            "It steps one copy from the avatar's true state and one from its model's: they never differed by "
            "more than %g m before.",
            static_cast<double>(t.pcc_bound));
      return v.contacts == 0 ? "It steps one copy from the avatar's true state and one from its model's: only the "
                               "model's copy hit a body."
                             : "It steps one copy from the avatar's true state and one from its model's: they did "
                               "different things to bodies.";
    case Predictor::kDensity:
      return fmt::sprintf("It counts bodies within %g m: %s %d of them were there.", static_cast<double>(t.radius),
                          warned ? "at least" : "never", t.count);
    case Predictor::kPathDensity:
      return warned ? "It looks for bodies beside the straight way to the avatar's target; when it warned, "
                      "there was one."
                    : "It looks for bodies beside the straight way to the avatar's target: there was none.";
  }
  return {};
}

std::string sentence(const Verdict& v, const Technique& t) {
  std::string s = reason(v, t);
  const char* event = v.contacts > 0 ? "contact" : "model's hit";
  if (v.warned > 0)
    s += fmt::sprintf(" It warned in %d of %d takes, %.2f s before the %s.", v.warned, v.takes, v.lead_s, event);
  if (v.contacts == 0) {
    const bool all = v.hits == 0;
    s += fmt::sprintf(" The model hit %sin %d of %d.", all ? "nothing " : "", all ? v.takes : v.hits, v.takes);
  }
  constexpr double kNoise = 0.005;  // m
  if (v.avoided_m < -kNoise) return s + fmt::sprintf(" It cost %.2f m more than no predictor.", -v.avoided_m);
  if (v.avoided_m <= kNoise) return s + " It avoided nothing.";
  s += fmt::sprintf(" %.2f of %.2f m avoided", v.avoided_m, v.cost_m);
  if (v.warned > 0) return s + ".";
  return s + ", by the low threshold during a contact, without any prediction.";
}

}  // namespace

Verdict judge(const std::string& story, const Variant& variant, const std::vector<Cost>& none,
              const std::vector<Cost>& with) {
  assert(none.size() == with.size());
  Verdict v;
  v.story = story;
  v.predictor = variant.predictor;
  v.takes = static_cast<int>(none.size());
  for (std::size_t i = 0; i < none.size(); ++i) {
    const Course& without = none[i].course;
    const Course& now = with[i].course;
    const Tick event = event_of(without);
    const bool warned = now.warned >= 0 && event >= 0 && now.warned < event;
    if (warned) v.lead_s += static_cast<double>(event - now.warned) / kTicksPerSecond;
    v.warned += warned ? 1 : 0;
    v.contacts += without.touched >= 0 ? 1 : 0;
    v.foreseen += now.touched >= 0 && now.warned >= 0 && now.warned < now.touched ? 1 : 0;
    v.hits += now.hit >= 0 ? 1 : 0;
    v.cost_m += none[i].final_m / v.takes;
    v.avoided_m += (none[i].final_m - with[i].final_m) / v.takes;
  }
  if (v.warned > 0) v.lead_s /= v.warned;
  v.sentence = sentence(v, variant.technique);
  return v;
}

}  // namespace padr::lab::examples
