#include "tools/support/technique_flags.h"

#include <algorithm>
#include <sstream>

#include "common/model/user_error.h"

namespace padr::support {
namespace {

constexpr std::array<Knob, TechniqueFlags::kKnobs> kKnobTable{{
    {"--threshold", "HIGH[:LOW]", "Avatar error in metres that sends an update; LOW when interaction is predicted",
     set_threshold},
    {"--body-threshold", "M|off", "The same for bodies under own authority", set_body_threshold},
    {"--model", "NAME", "What others believe of an avatar between updates: static, first, second (order) or input",
     set_model},
    {"--lead", "S", "How far ahead of its own motion the input model's target is told, seconds", set_lead},
    {"--time-space", "S|off", "Tell an avatar error once its integral over time exceeds threshold x this, seconds",
     set_time_space},
    {"--predictor", "NAME", "Of interaction: none, lookahead, density, path-density or pcc", set_predictor},
    {"--threshold-law", "NAME", "From prediction to threshold: two-level or continuous", set_law},
    {"--convergence", "NAME", "How the shown position follows a correction: snap, blend or pvb", set_convergence},
    {"--replay", "on|off", "Rewind and replay when an update comes late; off: apply it as if true on arrival",
     set_replay},
    {"--end-update", "on|off", "The end of a contact carries the states it leaves; off: only that it has ended",
     set_end_update},
    {"--proxy-update", "on|off", "Claim and tell what is reached through other bodies", set_proxy_update},
    {"--rest-state", "on|off", "Tell exactly where a body has come to rest; off: only that it is given up",
     set_rest_state},
    {"--precision", "exact|rounded", "Tell states to the bit, or rounded to far less than can be seen", set_precision},
    {"--unowned", "live|agreed",
     "Bodies that nobody owns: as a player's own world has them (the paper's), or as all agree", set_unowned},
    {"--time-stamps", "on|off", "Without replay: move an update on by its age when it arrives; off: as if true then",
     set_time_stamps},
    {"--radius", "M", "Surroundings that predictors look at, metres", set_radius},
    {"--steps", "N", "Ticks that predictors look ahead", set_steps},
    {"--count", "N", "Bodies in the vicinity that make it dense, for the density predictors", set_count},
    {"--pcc-bound", "M", "Predicted cost in metres above which LOW applies, for the pcc predictor", set_pcc_bound},
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

}  // namespace padr::support
