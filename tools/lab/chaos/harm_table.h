#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "shell/json.h"
#include "tools/lab/chaos/play.h"

namespace padr::lab {

/// What liars of one behaviour did to the honest, over many scripts.
struct HarmOfBehaviour {
  std::string_view name;
  int runs = 0;
  int violations = 0;
  Harm worst;           ///< the longest times; counts are summed
  Micros differed = 0;  ///< the longest, us
};

/// One line of fields of a JSON object: what the honest suffered in one script, or the worst of several.
void tell_harm(const Harm& harm, Micros differed, shell::Json& j);

/// By behaviour, in the order of behaviours().
class HarmTable {
 public:
  void add(std::string_view behaviour, const ChaosOutcome& outcome);
  /// For people; empty if there is nothing in it.
  std::string text() const;
  /// An array of objects.
  void tell(shell::Json& j) const;

 private:
  std::vector<HarmOfBehaviour> rows_;
};

}  // namespace padr::lab
