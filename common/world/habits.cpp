#include "common/world/habits.h"

#include <box2d/box2d.h>

#include <array>
#include <bit>
#include <cfloat>
#include <limits>

namespace padr::world {
namespace {

/// The value, which the compiler cannot know, so that the machine computes with it.
float unknown(float v) {
  volatile float u = v;
  return u;
}

// The square of kJustAbove is kSquare + 2^-24, and rounds to kSquare.
constexpr float kJustAbove = 1 + 0x1p-12F;
constexpr float kSquare = 1 + 0x1p-11F;

bool fuses() {
  const float a = unknown(kJustAbove);
  const float square = unknown(kSquare);
  return a * a - square != 0;
}

/// A determinant, a d - b c: which of the two products is fused is the compiler's choice.
bool box2d_fuses(float a, float b, float c, float d) {
  b2Mat33 m;
  m.SetZero();
  m.ex.Set(unknown(a), unknown(c), 0);
  m.ey.Set(unknown(b), unknown(d), 0);
  b2Mat33 inverse;
  m.GetInverse22(&inverse);
  return inverse.ex.x != 0;
}

bool reorders() {
  std::array<float, 64> terms{};
  for (std::size_t i = 0; i < terms.size(); ++i) terms[i] = unknown(i % 4 == 1 ? 0x1p24F : i % 4 == 3 ? -0x1p24F : 1);
  float sum = 0;
  for (const float t : terms) sum += t;
  volatile float one_by_one = 0;
  for (const float t : terms) one_by_one = one_by_one + t;
  return sum != one_by_one;
}

bool flushes() {
  const float least = std::numeric_limits<float>::min();
  return unknown(least) / 2 == 0 || unknown(least / 2) * 2 == 0;
}

bool rounds_away() {
  return unknown(1) + unknown(0x1p-25F) != 1 || unknown(1) - unknown(0x1p-26F) != 1 ||
         unknown(-1) - unknown(0x1p-25F) != -1;
}

}  // namespace

unsigned own_habits() {
  // The others are told from results that are rounded to the nearest.
  if (rounds_away()) return static_cast<unsigned>(Habit::kRoundsAway);
  unsigned habits = 0;
  const auto add = [&habits](Habit h, bool has) {
    if (has) habits |= static_cast<unsigned>(h);
  };
  add(Habit::kFuses, fuses());
  add(Habit::kBox2dFuses,
      box2d_fuses(kJustAbove, kSquare, 1, kJustAbove) || box2d_fuses(kSquare, kJustAbove, kJustAbove, 1));
  add(Habit::kWide, FLT_EVAL_METHOD != 0);
  add(Habit::kReorders, reorders());
  add(Habit::kFlushes, flushes());
  add(Habit::kOtherBytes, std::endian::native != std::endian::little);
  add(Habit::kOtherBox2d, b2_version.major != 2 || b2_version.minor != 4);
  return habits;
}

}  // namespace padr::world
