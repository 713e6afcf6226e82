#include "common/world/box2d_math.h"

#include "common/model/portable_math.h"

// Box2D calls these of the C library, whose last bits depend on the processor. A program that is linked with these
// definitions exports them, and the dynamic linker gives them to Box2D too: peers on different machines stay identical.

extern "C" {

float sinf(float x) noexcept {
  return static_cast<float>(padr::sin_cos(static_cast<double>(x)).sin);
}

float cosf(float x) noexcept {
  return static_cast<float>(padr::sin_cos(static_cast<double>(x)).cos);
}

void sincosf(float x, float* sine, float* cosine) noexcept {
  const padr::SinCos both = padr::sin_cos(static_cast<double>(x));
  *sine = static_cast<float>(both.sin);
  *cosine = static_cast<float>(both.cos);
}

float atan2f(float y, float x) noexcept {
  return static_cast<float>(padr::arc_tangent(static_cast<double>(y), static_cast<double>(x)));
}

}  // extern "C"

namespace padr::world {

void take_portable_math() {}

}  // namespace padr::world
