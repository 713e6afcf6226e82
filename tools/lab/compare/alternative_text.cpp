#include "tools/lab/compare/alternative_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>
#include <string_view>

#include "common/model/user_error.h"

namespace padr::lab::compare {
namespace {

using alternatives::Kind;
using alternatives::Spec;

struct Beginning {
  std::string_view name;
  Spec spec;
  std::string_view knobs;  ///< those that it takes, with blanks between
};

const std::array<Beginning, 5>& beginnings() {
  static const std::array<Beginning, 5> all{{
      {"rollback", {.kind = Kind::kInputs, .hz = 60}, "--input-delay --prediction --hz --steps-per-m"},
      {"lockstep",
       {.kind = Kind::kInputs, .hz = 60, .input_delay = 6, .prediction = 0},
       "--input-delay --hz --steps-per-m"},
      {"snapshot", {.kind = Kind::kSnapshot}, "--hz --steps-per-m"},
      {"state-sync", {.kind = Kind::kStateSync}, "--hz --steps-per-m"},
      {"dis", {.kind = Kind::kDis}, "--threshold"},
  }};
  return all;
}

struct Knob {
  std::string_view flag;
  std::string_view allowed;
  /// False if the value is not allowed.
  bool (*set)(Spec&, double);
};

bool is_whole(double v, int low, int high) {
  return v >= low && v <= high && v == static_cast<double>(static_cast<int>(v));
}

constexpr std::array<Knob, 5> kKnobs{{
    {"--input-delay", "0 to 60 ticks",
     [](Spec& s, double v) {
       if (!is_whole(v, 0, alternatives::kMostInputDelay)) return false;
       s.input_delay = static_cast<Tick>(v);
       return true;
     }},
    {"--prediction", "1 to 60 ticks",
     [](Spec& s, double v) {
       if (!is_whole(v, 1, alternatives::kMostPrediction)) return false;
       s.prediction = static_cast<Tick>(v);
       return true;
     }},
    {"--hz", "a divisor of 60; of state-sync any number from 1 to 60",
     [](Spec& s, double v) {
       if (!is_whole(v, 1, kTicksPerSecond)) return false;
       s.hz = static_cast<int>(v);
       return s.kind == Kind::kStateSync || kTicksPerSecond % s.hz == 0;
     }},
    {"--steps-per-m", "16 to 2048",
     [](Spec& s, double v) {
       if (!is_whole(v, 16, alternatives::kFinestPlace)) return false;
       s.steps_per_m = static_cast<int>(v);
       return true;
     }},
    {"--threshold", "0.001 to 100 m",
     [](Spec& s, double v) {
       s.position_threshold = static_cast<float>(v);
       return v >= 0.001 && v <= 100;
     }},
}};

void set_knob(const std::string& text, const Beginning& of, const std::string& flag, const std::string& value,
              Spec& s) {
  const auto* const knob =
      std::find_if(kKnobs.begin(), kKnobs.end(), [&flag](const Knob& k) { return k.flag == flag; });
  const bool takes = (std::string(" ") + std::string(of.knobs) + " ").find(" " + flag + " ") != std::string::npos;
  if (knob == kKnobs.end() || !takes)
    throw UserError("'" + text + "': '" + flag + "' is no knob of " + std::string(of.name) + "; give some of " +
                    std::string(of.knobs));
  double v{};
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), v);
  if (error != std::errc{} || end != value.data() + value.size() || !knob->set(s, v))
    throw UserError("'" + text + "': " + flag + ": '" + value + "' is not allowed; give " + std::string(knob->allowed));
}

}  // namespace

std::optional<Spec> alternative_of(const std::string& text) {
  std::istringstream words(text);
  std::string name;
  words >> name;
  const auto* const of =
      std::find_if(beginnings().begin(), beginnings().end(), [&name](const Beginning& b) { return b.name == name; });
  if (of == beginnings().end()) return std::nullopt;
  Spec s = of->spec;
  for (std::string word; words >> word;) {
    const std::size_t equals = word.find('=');
    const std::string flag = word.substr(0, equals);
    std::string value;
    if (equals != std::string::npos)
      value = word.substr(equals + 1);
    else
      words >> value;
    set_knob(text, *of, flag, value, s);
  }
  return s;
}

std::string help_on_alternatives() {
  std::string text;
  for (const Beginning& b : beginnings()) text += "  " + std::string(b.name) + " " + std::string(b.knobs) + "\n";
  for (const Knob& k : kKnobs) text += "  knob " + std::string(k.flag) + ": " + std::string(k.allowed) + "\n";
  return text;
}

}  // namespace padr::lab::compare
