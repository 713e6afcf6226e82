#include "shell/technique_flags.h"

namespace padr::shell {

void TechniqueFlags::declare(CLI::App& app) {
  const std::string group = "Technique";
  app.add_option("--technique", name_,
                 "avatar-only, fixed, adaptive (the paper's), full or everything; sets all knobs below")
      ->type_name("NAME")
      ->capture_default_str()
      ->group(group);
  for (std::size_t i = 0; i < kKnobCount; ++i) {
    const Knob& k = knobs()[i];
    options_[i] = app.add_option(k.flag, values_[i], k.help)->type_name(k.type)->group(group);
  }
}

Technique TechniqueFlags::technique() const {
  Technique t = technique_by_name(name_);
  for (std::size_t i = 0; i < kKnobCount; ++i)
    if (options_[i]->count() > 0) knobs()[i].set(t, values_[i]);
  return t;
}

}  // namespace padr::shell
