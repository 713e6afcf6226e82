#pragma once

namespace padr::world {

inline constexpr float kBox2dProbeStep = 1.0F / 60.0F;  // s

/// Whether Box2D has been kept from reading the clock; see the .cpp.
bool box2d_timers_stand_still();

}  // namespace padr::world
