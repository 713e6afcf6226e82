#pragma once

#include "common/model/vec.h"

namespace padr::sync {

/// What a step of something shown may change by, beyond what the entity's velocity explains, m a tick. Just below the
/// 3 cm that count as a jump.
inline constexpr float kMostChange = 0.028F;

/// The step of a tick that is nearest to `want` of those that a viewer takes for the motion of the same thing: no
/// farther than kMostChange from the last step, from the one that its velocity explains (`straight`), or from any
/// between (a bounce or a stop). All in m a tick.
Vec2 believable_stride(Vec2 want, Vec2 last, Vec2 straight);

/// The step that makes up for an offset in the least number of ticks, if no step may change by more than kMostChange
/// from one tick to the next and the last must end at rest: as fast as it can still be braked from (bang-bang control).
/// `offset`: from where it should be, m.
Vec2 fastest_glide(Vec2 offset);

}  // namespace padr::sync
