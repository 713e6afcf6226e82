#include "tools/support/technique_flags.h"

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
    {"--radius", "M", "Surroundings that predictors look at, metres", set_radius},
    {"--steps", "N", "Ticks that predictors look ahead", set_steps},
    {"--count", "N", "Bodies in the vicinity that make it dense, for the density predictors", set_count},
    {"--pcc-bound", "M", "Predicted cost in metres above which LOW applies, for the pcc predictor", set_pcc_bound},
}};

}  // namespace

std::span<const Knob> knobs() {
  return kKnobTable;
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
