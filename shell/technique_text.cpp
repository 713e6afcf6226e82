#include "shell/technique_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <sstream>
#include <utility>

#include "common/model/user_error.h"

namespace padr::shell {
namespace {

template <typename Value, std::size_t N>
using Names = std::array<std::pair<std::string_view, Value>, N>;

constexpr Names<Model, 5> kModels{{{"static", Model::kStatic},
                                   {"first", Model::kFirst},
                                   {"second", Model::kSecond},
                                   {"input", Model::kInput},
                                   {"auto", Model::kChosen}}};
constexpr Names<Predictor, 5> kPredictors{{{"none", Predictor::kNone},
                                           {"lookahead", Predictor::kLookahead},
                                           {"density", Predictor::kDensity},
                                           {"path-density", Predictor::kPathDensity},
                                           {"pcc", Predictor::kPcc}}};
constexpr Names<ThresholdLaw, 2> kLaws{
    {{"two-level", ThresholdLaw::kTwoLevel}, {"continuous", ThresholdLaw::kContinuous}}};
constexpr Names<Convergence, 4> kConvergences{{{"snap", Convergence::kSnap},
                                               {"blend", Convergence::kBlend},
                                               {"pvb", Convergence::kPvb},
                                               {"track", Convergence::kTrack}}};
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

template <auto kField, const auto& kNames>
void named(Technique& t, std::string_view flag, std::string_view value) {
  t.*kField = by_name(flag, value, kNames);
}

void set_threshold(Technique& t, std::string_view flag, std::string_view value) {
  const auto colon = value.find(':');
  const float high = in_range(flag, value.substr(0, colon), kLeast, kMost, "metres, or HIGH:LOW", value);
  const float low = colon == std::string_view::npos
                        ? high
                        : in_range(flag, value.substr(colon + 1), kLeast, kMost, "metres, or HIGH:LOW", value);
  if (low > high) refuse(flag, value, "HIGH:LOW with HIGH >= LOW");
  t.threshold_high = high;
  t.threshold_low = low;
}

using Text = std::string_view;

constexpr std::array<Knob, kKnobCount> kKnobs{{
    {"--threshold", "HIGH[:LOW]", "Avatar error in metres that sends an update; LOW when a contact is predicted",
     set_threshold},
    {"--body-threshold", "M|off", "The same for bodies under own authority",
     [](Technique& t, Text flag, Text v) {
       t.body_threshold = v == "off" ? 0 : in_range(flag, v, kLeast, kMost, "metres, or off");
     }},
    {"--model", "NAME",
     "How others continue an avatar between updates: static, first, second (order), input or auto; auto: each update"
     " chooses second or input",
     named<&Technique::model, kModels>},
    {"--lead", "S",
     "Input model: send the target's position as it will be in S seconds, and in twice as many if an update takes 250 "
     "ms",
     [](Technique& t, Text flag, Text v) { t.lead = in_range(flag, v, 0.0F, 1.0F, "seconds"); }},
    {"--foresee", "S|off", "Also send an update for an error that will be four times the threshold in S seconds",
     [](Technique& t, Text flag, Text v) {
       t.foresee = v == "off" ? 0 : in_range(flag, v, 0.01F, 1.0F, "seconds, or off");
     }},
    {"--time-space", "S|off", "Also send an update when the integral of the error over time exceeds threshold x S",
     [](Technique& t, Text flag, Text v) {
       t.time_space = v == "off" ? 0 : in_range(flag, v, 0.001F, 100.0F, "seconds, or off");
     }},
    {"--predictor", "NAME", "How contacts are predicted: none, lookahead, density, path-density or pcc",
     named<&Technique::predictor, kPredictors>},
    {"--threshold-law", "NAME", "How a prediction sets the threshold: two-level or continuous",
     named<&Technique::law, kLaws>},
    {"--convergence", "NAME", "How the shown position follows a correction: snap, blend, pvb or track",
     named<&Technique::convergence, kConvergences>},
    {"--replay", "on|off", "A late update rewinds and replays the world; off: it is applied unchanged on arrival",
     named<&Technique::replay, kSwitch>},
    {"--end-update", "on|off", "When a contact ends, send the states of its bodies; off: only that it has ended",
     named<&Technique::end_update, kSwitch>},
    {"--proxy-update", "on|off", "Also claim and send bodies that the avatar touches through other bodies",
     named<&Technique::proxy_update, kSwitch>},
    {"--rest-state", "on|off", "When a body comes to rest, send its exact state; off: only that it is released",
     named<&Technique::rest_state, kSwitch>},
    {"--precision", "exact|rounded", "Send states to the bit, or rounded by less than anybody can see",
     named<&Technique::precision, kPrecisions>},
    {"--unowned", "live|agreed",
     "Bodies that nobody owns move by the player's own live world (live, our reading of the paper) or by the predicted "
     "world "
     "(agreed)",
     named<&Technique::unowned, kUnowned>},
    {"--time-stamps", "on|off", "Without replay: extrapolate an update by its age on arrival; off: apply it unchanged",
     named<&Technique::time_stamps, kSwitch>},
    {"--budget", "KBIT|off",
     "Tell no more than fits into so many kbit/s to all other peers together, IP and UDP headers included; marks and "
     "repeats go out even beyond it",
     [](Technique& t, Text flag, Text v) {
       t.budget = v == "off" ? 0 : in_range(flag, v, 1.0F, 100'000.0F, "kbit/s, or off");
     }},
    {"--radius", "M", "Predictors look at bodies up to this distance, metres",
     [](Technique& t, Text flag, Text v) { t.radius = in_range(flag, v, 0.1F, 100.0F, "metres"); }},
    {"--steps", "N", "Ticks that predictors look ahead",
     [](Technique& t, Text flag, Text v) { t.steps = in_range(flag, v, 1, 600, "ticks"); }},
    {"--count", "N", "The density predictor warns at this number of near bodies",
     [](Technique& t, Text flag, Text v) { t.count = in_range(flag, v, 1, 5000, "bodies"); }},
    {"--pcc-bound", "M", "The pcc predictor warns above this predicted cost, metres",
     [](Technique& t, Text flag, Text v) { t.pcc_bound = in_range(flag, v, 0.0F, 1000.0F, "metres"); }},
}};

}  // namespace

std::span<const Knob, kKnobCount> knobs() {
  return kKnobs;
}

Technique technique_of(std::string_view text) {
  std::istringstream words{std::string(text)};
  std::string name;
  words >> name;
  Technique t = technique_by_name(name);
  for (std::string word; words >> word;) {
    const std::size_t equals = word.find('=');
    const std::string flag = word.substr(0, equals);
    const auto knob = std::find_if(kKnobs.begin(), kKnobs.end(), [&flag](const Knob& k) { return flag == k.flag; });
    if (knob == kKnobs.end()) {
      std::string allowed;
      for (const Knob& k : kKnobs) allowed += (allowed.empty() ? "" : ", ") + std::string(k.flag);
      throw UserError("'" + std::string(text) + "': '" + flag + "' is no knob of a technique; give some of " + allowed);
    }
    std::string value;
    if (equals != std::string::npos)
      value = word.substr(equals + 1);
    else if (!(words >> value))
      throw UserError("'" + std::string(text) + "': " + flag + " has no value; give " + knob->type);
    knob->set(t, value);
  }
  return t;
}

std::string describe(const Technique& t) {
  std::string s = t.name;
  s += " --threshold " + number(t.threshold_high);
  if (t.threshold_low != t.threshold_high) s += ":" + number(t.threshold_low);
  s += " --body-threshold " + (t.body_threshold > 0 ? number(t.body_threshold) : std::string("off"));
  s += " --replay " + name_of(t.replay, kSwitch) + " --model " + name_of(t.model, kModels);
  if (tells_input(t)) s += " --lead " + number(t.lead);
  s += " --foresee " + (t.foresee > 0 ? number(t.foresee) : std::string("off"));
  s += " --time-space " + (t.time_space > 0 ? number(t.time_space) : std::string("off"));
  s += " --predictor " + name_of(t.predictor, kPredictors) + " --threshold-law " + name_of(t.law, kLaws);
  s += " --convergence " + name_of(t.convergence, kConvergences) + " --radius " + number(t.radius);
  if (!t.end_update) s += " --end-update off";
  if (!t.proxy_update) s += " --proxy-update off";
  if (!t.rest_state) s += " --rest-state off";
  s += " --precision " + name_of(t.precision, kPrecisions) + " --unowned " + name_of(t.unowned, kUnowned);
  if (t.time_stamps) s += " --time-stamps on";
  if (t.budget > 0) s += " --budget " + number(t.budget);
  s += " --steps " + number(t.steps) + " --count " + number(t.count) + " --pcc-bound " + number(t.pcc_bound);
  return s;
}

}  // namespace padr::shell
