#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <span>
#include <string>
#include <string_view>

#include "common/model/technique.h"

namespace padr::shell {

/// A setting of a technique as a flag.
struct Knob {
  const char* flag;
  const char* type;
  const char* help;
  /// Throws UserError that names the flag, the value and what is allowed.
  void (*set)(Technique&, std::string_view);
};

/// All there are, in the order of help texts.
std::span<const Knob> knobs();

/// A technique as one text: its name, and knobs as flags, such as "full --threshold 0.3:0.1 --lead 0.2". Throws
/// UserError that names the flag, the value and what is allowed.
Technique technique_of(std::string_view text);

/// Flags for every knob of a technique. The name sets all knobs, then those given by themselves override it, wherever
/// on the command line they stand.
class TechniqueFlags {
 public:
  static constexpr std::size_t kKnobs = 19;

  void declare(CLI::App& app);
  /// After parsing. Throws UserError that names the flag, the value and what is allowed.
  Technique technique() const;

 private:
  std::string name_ = "full";
  std::array<std::string, kKnobs> values_;
  std::array<CLI::Option*, kKnobs> options_{};
};

}  // namespace padr::shell
