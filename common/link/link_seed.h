#pragma once

#include <cstdint>

#include "common/model/ids.h"
#include "common/model/rng.h"

namespace padr::link {

/// Seed of the shim from one peer to another; the same in the lab and in real peers.
inline std::uint64_t link_seed(std::uint64_t netem_seed, PeerId from, PeerId to) {
  return derive_seed(netem_seed, from + 1U, to + 1U);
}

}  // namespace padr::link
