#include "shell/technique_flags.h"

#include <algorithm>
#include <sstream>

#include "common/model/user_error.h"

namespace padr::shell {
namespace {

constexpr std::array<Knob, TechniqueFlags::kKnobs> kKnobTable{{
    {"--threshold", "HIGH[:LOW]", "Avatar error in metres that sends an update; LOW when a contact is predicted",
     set_threshold},
    {"--body-threshold", "M|off", "The same for bodies under own authority", set_body_threshold},
    {"--model", "NAME", "How others continue an avatar between updates: static, first, second (order) or input",
     set_model},
    {"--lead", "S", "Input model: send the target's position as it will be in S seconds", set_lead},
    {"--time-space", "S|off", "Also send an update when the integral of the error over time exceeds threshold x S",
     set_time_space},
    {"--predictor", "NAME", "How contacts are predicted: none, lookahead, density, path-density or pcc", set_predictor},
    {"--threshold-law", "NAME", "How a prediction sets the threshold: two-level or continuous", set_law},
    {"--convergence", "NAME", "How the shown position follows a correction: snap, blend or pvb", set_convergence},
    {"--replay", "on|off", "A late update rewinds and replays the world; off: it is applied unchanged on arrival",
     set_replay},
    {"--end-update", "on|off", "When a contact ends, send the states of its bodies; off: only that it has ended",
     set_end_update},
    {"--proxy-update", "on|off", "Also claim and send bodies that the avatar touches through other bodies",
     set_proxy_update},
    {"--rest-state", "on|off", "When a body comes to rest, send its exact state; off: only that it is released",
     set_rest_state},
    {"--precision", "exact|rounded", "Send states to the bit, or rounded by less than anybody can see", set_precision},
    {"--unowned", "live|agreed",
     "Bodies that nobody owns move by the player's own live world (live, the paper's) or by the predicted world "
     "(agreed)",
     set_unowned},
    {"--time-stamps", "on|off", "Without replay: extrapolate an update by its age on arrival; off: apply it unchanged",
     set_time_stamps},
    {"--radius", "M", "Predictors look at bodies up to this distance, metres", set_radius},
    {"--steps", "N", "Ticks that predictors look ahead", set_steps},
    {"--count", "N", "The density predictor warns at this number of near bodies", set_count},
    {"--pcc-bound", "M", "The pcc predictor warns above this predicted cost, metres", set_pcc_bound},
}};

}  // namespace

std::span<const Knob> knobs() {
  return kKnobTable;
}

Technique technique_of(std::string_view text) {
  std::istringstream words{std::string(text)};
  std::string name;
  words >> name;
  Technique t = technique_by_name(name);
  for (std::string word; words >> word;) {
    const std::size_t equals = word.find('=');
    const std::string flag = word.substr(0, equals);
    const auto knob =
        std::find_if(kKnobTable.begin(), kKnobTable.end(), [&flag](const Knob& k) { return flag == k.flag; });
    if (knob == kKnobTable.end()) {
      std::string allowed;
      for (const Knob& k : kKnobTable) allowed += (allowed.empty() ? "" : ", ") + std::string(k.flag);
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

void TechniqueFlags::declare(CLI::App& app) {
  const std::string group = "Technique";
  app.add_option("--technique", name_,
                 "avatar-only, fixed, adaptive (the paper's), full or everything; sets all knobs below")
      ->type_name("NAME")
      ->capture_default_str()
      ->group(group);
  for (std::size_t i = 0; i < kKnobs; ++i) {
    const Knob& k = kKnobTable[i];
    options_[i] = app.add_option(k.flag, values_[i], k.help)->type_name(k.type)->group(group);
  }
}

Technique TechniqueFlags::technique() const {
  Technique t = technique_by_name(name_);
  for (std::size_t i = 0; i < kKnobs; ++i)
    if (options_[i]->count() > 0) kKnobTable[i].set(t, values_[i]);
  return t;
}

}  // namespace padr::shell
