#include "common/world/box2d_timer.h"

#include <box2d/box2d.h>

// Box2D asks the system for the time several times a step and once more for every island, to fill a profile that nobody
// here reads: a quarter of the time of small steps, and a clock inside the core. These definitions take the place of
// the library's own when the program is linked.

b2Timer::b2Timer() {
  Reset();
}

void b2Timer::Reset() {
  m_start_sec = 0;
  m_start_usec = 0;
}

float b2Timer::GetMilliseconds() const {
  return 0;
}

namespace padr::world {

bool box2d_timers_stand_still() {
  b2World world({0, 0});
  world.Step(kBox2dProbeStep, 1, 1);
  // A step of even an empty world takes longer than nothing, if anybody looks at a clock.
  return world.GetProfile().step == 0;
}

}  // namespace padr::world
