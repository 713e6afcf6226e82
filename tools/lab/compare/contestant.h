#pragma once

#include <string>
#include <variant>
#include <vector>

#include "common/model/technique.h"
#include "tools/lab/alternatives/spec.h"

namespace padr::lab::compare {

enum class Group : std::uint8_t {
  kPaper,        ///< the paper's three
  kOurs,         ///< full, and everything at every tick
  kAblation,     ///< full without one of its parts
  kAlternative,  ///< what other people do
};

/// One technique of a comparison.
struct Contestant {
  std::string id;      ///< as --techniques takes it
  std::string series;  ///< what shares a key entry in the plot; look_of() knows its beginning
  std::string mark;    ///< label of its point
  Group group = Group::kOurs;
  std::string what;  ///< one line for people
  std::variant<Technique, alternatives::Spec> how;
  /// The setting, knob by knob, in the form the flags take; of an alternative `what`.
  std::string setting() const;
};

/// All there are. Each name is one setting; an ablation differs from `full` in one knob.
std::vector<Contestant> all_contestants();
/// Those of a list with commas between: ids, or the groups `paper`, `ours`, `ablations`, `alternatives`, `all`. In the
/// order of all_contestants, each once. Throws UserError that names the flag, the word and what is allowed.
std::vector<Contestant> chosen_contestants(const std::string& list);
/// A technique with knobs, as shell::technique_of takes it; its id is the text. Throws UserError.
Contestant added_contestant(const std::string& text);

}  // namespace padr::lab::compare
