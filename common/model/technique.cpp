#include "common/model/technique.h"

#include <array>
#include <cmath>

#include "common/model/user_error.h"

namespace padr {
namespace {

constexpr float kMostNumber = 1.0e6F;  // m, s, kbit/s
constexpr int kMostCount = 100'000;    // ticks, bodies

struct Choice {
  const char* field;
  unsigned value;
  unsigned most;
};
template <typename Value>
Choice choice(const char* field, Value value, Value last) {
  return {field, static_cast<unsigned>(value), static_cast<unsigned>(last)};
}

struct Number {
  const char* field;
  float value;
};

}  // namespace

std::string wrong_field(const Technique& t) {
  const auto refusal = [](const char* field, const auto& value, const auto& most) {
    return std::string(field) + ": " + std::to_string(value) + " is not allowed; give 0 to " + std::to_string(most);
  };
  for (const Choice& c : std::array{
           choice("model", t.model, Model::kChosen), choice("predictor", t.predictor, Predictor::kPcc),
           choice("law", t.law, ThresholdLaw::kContinuous), choice("convergence", t.convergence, Convergence::kTrack),
           choice("precision", t.precision, Precision::kRounded), choice("unowned", t.unowned, Unowned::kLive)})
    if (c.value > c.most) return refusal(c.field, c.value, c.most);
  for (const Number& n :
       std::array{Number{"lead", t.lead}, Number{"time_space", t.time_space}, Number{"foresee", t.foresee},
                  Number{"threshold_high", t.threshold_high}, Number{"threshold_low", t.threshold_low},
                  Number{"body_threshold", t.body_threshold}, Number{"radius", t.radius},
                  Number{"pcc_bound", t.pcc_bound}, Number{"budget", t.budget}})
    if (!std::isfinite(n.value) || n.value < 0 || n.value > kMostNumber) return refusal(n.field, n.value, 1'000'000);
  if (t.steps < 0 || t.steps > kMostCount) return refusal("steps", t.steps, kMostCount);
  if (t.count < 0 || t.count > kMostCount) return refusal("count", t.count, kMostCount);
  return "";
}

std::vector<std::string_view> technique_names() {
  return {"avatar-only", "fixed", "adaptive", "full", "everything"};
}

Technique technique_by_name(std::string_view name) {
  Technique t;
  t.name = std::string(name);
  if (name == "full") return t;
  // What others are measured against is told to the bit, and takes what it takes.
  t.budget = 0;
  t.precision = Precision::kExact;
  if (name == "everything") {
    t.predictor = Predictor::kNone;  // no threshold waits for it
    t.every_tick = true;
    return t;
  }
  // The three of the paper: first order, updates applied on arrival, one for every contact and chain, a world of one's
  // own.
  t.unowned = Unowned::kLive;
  t.replay = false;
  t.model = Model::kFirst;
  t.time_space = 0;
  t.foresee = 0;
  t.threshold_high = 0.8F;
  t.threshold_low = 0.3F;
  t.body_threshold = 0;
  t.update_every_contact = true;
  if (name == "adaptive") return t;
  t.predictor = Predictor::kNone;
  t.threshold_high = t.threshold_low = 0.5F;
  if (name == "fixed") return t;
  t.authority = false;
  if (name == "avatar-only") return t;
  throw UserError("--technique: '" + t.name +
                  "' is not allowed; give one of avatar-only, fixed, adaptive, full, everything");
}

}  // namespace padr
