#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <string>

#include "shell/technique_text.h"

namespace padr::shell {

/// Flags for every knob of a technique. The name sets all knobs, then those given by themselves override it, wherever
/// on the command line they stand.
class TechniqueFlags {
 public:
  void declare(CLI::App& app);
  /// After parsing. Throws UserError that names the flag, the value and what is allowed.
  Technique technique() const;

 private:
  std::string name_ = "full";
  std::array<std::string, kKnobCount> values_;
  std::array<CLI::Option*, kKnobCount> options_{};
};

}  // namespace padr::shell
