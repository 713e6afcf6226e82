#include "common/model/technique.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <utility>

#include "common/model/user_error.h"

namespace padr {
namespace {

template <typename Value, std::size_t N>
using Names = std::array<std::pair<std::string_view, Value>, N>;

constexpr Names<Model, 4> kModels{
    {{"static", Model::kStatic}, {"first", Model::kFirst}, {"second", Model::kSecond}, {"input", Model::kInput}}};
constexpr Names<Predictor, 5> kPredictors{{{"none", Predictor::kNone},
                                           {"lookahead", Predictor::kLookahead},
                                           {"density", Predictor::kDensity},
                                           {"path-density", Predictor::kPathDensity},
                                           {"pcc", Predictor::kPcc}}};
constexpr Names<ThresholdLaw, 2> kLaws{
    {{"two-level", ThresholdLaw::kTwoLevel}, {"continuous", ThresholdLaw::kContinuous}}};
constexpr Names<Convergence, 3> kConvergences{
    {{"snap", Convergence::kSnap}, {"blend", Convergence::kBlend}, {"pvb", Convergence::kPvb}}};
constexpr Names<Precision, 2> kPrecisions{{{"exact", Precision::kExact}, {"rounded", Precision::kRounded}}};
constexpr Names<Unowned, 2> kUnowned{{{"live", Unowned::kLive}, {"agreed", Unowned::kAgreed}}};
constexpr Names<bool, 2> kSwitch{{{"on", true}, {"off", false}}};

[[noreturn]] void refuse(std::string_view flag, std::string_view text, const std::string& allowed) {
  throw UserError(std::string(flag) + ": '" + std::string(text) + "' is not allowed; give " + allowed);
}

template <typename Value, std::size_t N>
Value by_name(std::string_view flag, std::string_view text, const Names<Value, N>& names) {
  std::string allowed;
  for (const auto& [name, value] : names) {
    if (name == text) return value;
    allowed += (allowed.empty() ? "" : ", ") + std::string(name);
  }
  refuse(flag, text, "one of " + allowed);
}

template <typename Value, std::size_t N>
std::string name_of(Value value, const Names<Value, N>& names) {
  for (const auto& [name, v] : names)
    if (v == value) return std::string(name);
  return "?";
}

std::string number(double v) {
  std::array<char, 32> text{};
  const int n = std::snprintf(text.data(), text.size(), "%g", v);
  return {text.data(), static_cast<std::size_t>(n)};
}

template <typename T>
T in_range(std::string_view flag, std::string_view text, T lo, T hi, std::string_view unit,
           std::string_view whole = {}) {
  T v{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
  if (error != std::errc{} || end != text.data() + text.size() || !(v >= lo && v <= hi))
    refuse(flag, whole.empty() ? text : whole, number(lo) + " to " + number(hi) + " " + std::string(unit));
  return v;
}

constexpr float kLeast = 0.001F;  // m; far below what Box2D resolves
constexpr float kMost = 100.0F;   // m

}  // namespace

std::vector<std::string_view> technique_names() {
  return {"avatar-only", "fixed", "adaptive", "full", "everything"};
}

Technique technique_by_name(std::string_view name) {
  Technique t;
  t.name = std::string(name);
  if (name == "full") return t;
  // What others are measured against is told to the bit.
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
  t.body_threshold = 0;
  t.update_every_contact = true;
  if (name == "adaptive") return t;
  t.predictor = Predictor::kNone;
  t.threshold_high = t.threshold_low = 0.5F;
  if (name == "fixed") return t;
  t.authority = false;
  if (name == "avatar-only") return t;
  refuse("--technique", name, "one of avatar-only, fixed, adaptive, full, everything");
}

void set_threshold(Technique& t, std::string_view text) {
  const auto colon = text.find(':');
  const float high = in_range("--threshold", text.substr(0, colon), kLeast, kMost, "metres, or HIGH:LOW", text);
  const float low = colon == std::string_view::npos
                        ? high
                        : in_range("--threshold", text.substr(colon + 1), kLeast, kMost, "metres, or HIGH:LOW", text);
  if (low > high) refuse("--threshold", text, "HIGH:LOW with HIGH >= LOW");
  t.threshold_high = high;
  t.threshold_low = low;
}

void set_body_threshold(Technique& t, std::string_view text) {
  t.body_threshold = text == "off" ? 0 : in_range("--body-threshold", text, kLeast, kMost, "metres, or off");
}
void set_model(Technique& t, std::string_view text) {
  t.model = by_name("--model", text, kModels);
}
void set_predictor(Technique& t, std::string_view text) {
  t.predictor = by_name("--predictor", text, kPredictors);
}
void set_law(Technique& t, std::string_view text) {
  t.law = by_name("--threshold-law", text, kLaws);
}
void set_convergence(Technique& t, std::string_view text) {
  t.convergence = by_name("--convergence", text, kConvergences);
}
void set_lead(Technique& t, std::string_view text) {
  t.lead = in_range("--lead", text, 0.0F, 1.0F, "seconds");
}
void set_time_space(Technique& t, std::string_view text) {
  t.time_space = text == "off" ? 0 : in_range("--time-space", text, 0.001F, 100.0F, "seconds, or off");
}
void set_replay(Technique& t, std::string_view text) {
  t.replay = by_name("--replay", text, kSwitch);
}
void set_radius(Technique& t, std::string_view text) {
  t.radius = in_range("--radius", text, 0.1F, 100.0F, "metres");
}
void set_steps(Technique& t, std::string_view text) {
  t.steps = in_range("--steps", text, 1, 600, "ticks");
}
void set_count(Technique& t, std::string_view text) {
  t.count = in_range("--count", text, 1, 5000, "bodies");
}
void set_end_update(Technique& t, std::string_view text) {
  t.end_update = by_name("--end-update", text, kSwitch);
}
void set_proxy_update(Technique& t, std::string_view text) {
  t.proxy_update = by_name("--proxy-update", text, kSwitch);
}
void set_rest_state(Technique& t, std::string_view text) {
  t.rest_state = by_name("--rest-state", text, kSwitch);
}
void set_pcc_bound(Technique& t, std::string_view text) {
  t.pcc_bound = in_range("--pcc-bound", text, 0.0F, 1000.0F, "metres");
}
void set_precision(Technique& t, std::string_view text) {
  t.precision = by_name("--precision", text, kPrecisions);
}
void set_unowned(Technique& t, std::string_view text) {
  t.unowned = by_name("--unowned", text, kUnowned);
}
void set_time_stamps(Technique& t, std::string_view text) {
  t.time_stamps = by_name("--time-stamps", text, kSwitch);
}

std::string describe(const Technique& t) {
  std::string s = t.name;
  s += " --threshold " + number(t.threshold_high);
  if (t.threshold_low != t.threshold_high) s += ":" + number(t.threshold_low);
  s += " --body-threshold " + (t.body_threshold > 0 ? number(t.body_threshold) : std::string("off"));
  s += " --replay " + name_of(t.replay, kSwitch) + " --model " + name_of(t.model, kModels);
  if (t.model == Model::kInput) s += " --lead " + number(t.lead);
  s += " --time-space " + (t.time_space > 0 ? number(t.time_space) : std::string("off"));
  s += " --predictor " + name_of(t.predictor, kPredictors) + " --threshold-law " + name_of(t.law, kLaws);
  s += " --convergence " + name_of(t.convergence, kConvergences) + " --radius " + number(t.radius);
  if (!t.end_update) s += " --end-update off";
  if (!t.proxy_update) s += " --proxy-update off";
  if (!t.rest_state) s += " --rest-state off";
  s += " --precision " + name_of(t.precision, kPrecisions) + " --unowned " + name_of(t.unowned, kUnowned);
  if (t.time_stamps) s += " --time-stamps on";
  s += " --steps " + number(t.steps) + " --count " + number(t.count) + " --pcc-bound " + number(t.pcc_bound);
  return s;
}

}  // namespace padr
