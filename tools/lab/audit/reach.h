#pragma once

#include <vector>

#include "tools/lab/audit/finding.h"
#include "tools/lab/audit/surroundings.h"

namespace padr::lab::audit {

/// Something of a member's, and how far from there it may really be, m.
struct Place {
  EntityId entity = 0;
  Vec2 at;
  float unsure = 0;
};

/// Of each of the bodies that a member claims with one update, how much is missing for a chain of contacts to lead
/// there from the member's avatar or from a body that it owns: the sum of the gaps in the best chain, m. Links may be
/// other bodies of the update, and any body that has been stirred lately.
std::vector<Measure> judge_claims(const Limits& limits, const Surroundings& around, const std::vector<Place>& own,
                                  const std::vector<Place>& claims);

}  // namespace padr::lab::audit
