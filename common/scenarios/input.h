#pragma once

#include "common/model/ids.h"
#include "common/model/vec.h"

namespace padr::scenarios {

/// Where a user wants the avatar to be, for whom or whatever does the wanting.
class InputSource {
 public:
  virtual ~InputSource() = default;
  /// The point the avatar is drawn towards during step `tick`, m; tick 0 stands for any before it. The answer depends
  /// on the tick alone: neither on how often nor in which order ticks are asked for.
  virtual Vec2 target(Tick tick) = 0;
};

}  // namespace padr::scenarios
