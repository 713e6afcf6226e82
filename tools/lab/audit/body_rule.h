#pragma once

#include <optional>
#include <vector>

#include "tools/lab/audit/finding.h"
#include "tools/lab/audit/limits.h"

namespace padr::lab::audit {

/// A state of a body that a member told, and what is known to judge it by.
struct BodyCase {
  EntityId body = 0;
  BodyState state;
  float fastest = 0;  ///< m/s, of anything else lately, and of this body as it is agreed
  bool pushed = false;
  /// The member's last word on the body under the same authority, if there is one: where, and how long ago.
  struct Before {
    Vec2 position;
    float seconds = 0;
  };
  std::optional<Before> before;
  /// Where the body is agreed to have lain untouched for so long that the member knows of it.
  std::optional<Vec2> lay_at;
  float jump = 0;  ///< m, that it may have moved from there
};

/// Its speed, its spin, its way.
std::vector<Measure> judge(const Limits& limits, const BodyCase& c);

}  // namespace padr::lab::audit
