#pragma once

#include <cstddef>

#include "tools/lab/crowd/crowd.h"

namespace padr::lab {

/// Where the bodies of a crowd are, as the confirmed worlds of its regions have it.
struct BodyPositions {
  std::size_t regions = 0;  ///< that somebody is in
  std::size_t bodies = 0;   ///< different ones
  std::size_t lost = 0;     ///< of those that began in these regions: in none of them
  std::size_t doubled = 0;  ///< in two regions: being handed over
  std::size_t abroad = 0;   ///< in another region than they began in
};

BodyPositions inventory_of(const CrowdRun& run, const crowd::Plane& plane);

}  // namespace padr::lab
