#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "common/model/technique.h"

namespace padr::shell {

/// A setting of a technique as people write it.
struct Knob {
  const char* flag;
  const char* type;
  const char* help;
  void (*read)(Technique&, std::string_view flag, std::string_view value);

  /// Throws UserError that names the flag, the value and what is allowed.
  void set(Technique& t, std::string_view value) const { read(t, flag, value); }
};

inline constexpr std::size_t kKnobCount = 21;
/// All there are, in the order of help texts.
std::span<const Knob, kKnobCount> knobs();

/// A technique as one text: its name, and knobs as flags, such as "full --threshold 0.3:0.1 --lead 0.2". Throws
/// UserError that names the flag, the value and what is allowed.
Technique technique_of(std::string_view text);

/// One line: the name and every knob, in the form the flags take.
std::string describe(const Technique& t);

}  // namespace padr::shell
