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
  kFrontier,     ///< further points of their curves, and of full's
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

/// Whether it is a point of full's curve over budgets.
bool is_budget_of_full(const Contestant& c);

/// All there are. Each name is one setting; an ablation differs from `full` in one knob.
std::vector<Contestant> all_contestants();
/// Those of a list with commas between: ids, or the groups `paper`, `ours`, `ablations`, `alternatives`, `all` (these
/// four) and `frontier` (the curves: all budgets of full, everything, and alternatives with all their further points).
/// In the order of all_contestants, each once. Throws UserError that names the flag, the word and what is allowed.
std::vector<Contestant> chosen_contestants(const std::string& list);
/// A technique or an alternative with knobs, as shell::technique_of and alternative_of take it; its id is the text.
/// Throws UserError.
Contestant added_contestant(const std::string& text);

}  // namespace padr::lab::compare
