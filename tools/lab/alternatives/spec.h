#pragma once

#include <cstdint>

namespace padr::lab::alternatives {

enum class Kind : std::uint8_t { kSnapshot, kStateSync, kDis };

/// Which alternative, and its parameters.
struct Spec {
  Kind kind = Kind::kSnapshot;
  int hz = 20;                      ///< datagrams a second to each peer: state-sync 1 .. 60, snapshot a divisor of 60
  float position_threshold = 1;     ///< m, dis
  float angle_threshold = 0.0524F;  ///< rad, dis; 3 degrees
};

}  // namespace padr::lab::alternatives
