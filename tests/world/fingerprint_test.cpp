#include "common/world/fingerprint.h"

#include <gtest/gtest.h>

#include <cfenv>
#include <string>
#include <vector>

#include "common/model/hash.h"

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace padr::world {
namespace {

constexpr unsigned kHabitsShift = 56;
constexpr unsigned kFunctionsShift = 40;
constexpr unsigned kLonersShift = 24;

std::uint64_t with(Habit h) {
  return std::uint64_t{static_cast<unsigned>(h)} << kHabitsShift;
}

std::string difference(std::uint64_t a, std::uint64_t b) {
  return physics_difference(a, b, "the one", "the other");
}

// The value is that of every processor, compiler and build. A change of the physics, or of what is hashed, changes it:
// then docs/determinism.md, too.
TEST(Fingerprint, IsThatOfEveryMachine) {
  EXPECT_EQ(hex(physics_fingerprint()), "009cef621ab154a0");
  EXPECT_EQ(physics_fingerprint(), physics_fingerprint());
  EXPECT_EQ(habits_text(physics_fingerprint()), "");
}

TEST(Fingerprint, EachHabitIsNamedWithItsOwnerAndItsCure) {
  struct Row {
    Habit habit;
    const char* is;
    const char* cure;
  };
  const std::vector<Row> rows{
      {Habit::kFuses, "fuses multiplications and additions", "-ffp-contract=off"},
      {Habit::kBox2dFuses, "has a Box2D that fuses", "PADR_BOX2D_SOURCE"},
      {Habit::kWide, "more digits than float", "-mfpmath=sse"},
      {Habit::kReorders, "adds in another order", "-ffast-math"},
      {Habit::kFlushes, "takes tiny numbers for 0", "-ffast-math"},
      {Habit::kRoundsAway, "does not round to the nearest", "what sets the rounding"},
      {Habit::kOtherBytes, "highest byte", "little-endian"},
      {Habit::kOtherBox2d, "another Box2D than 2.4", "compile it with Box2D 2.4.1"},
  };
  for (const Row& r : rows) {
    SCOPED_TRACE(r.is);
    const std::string first = difference(with(r.habit) + 5, 7);
    EXPECT_EQ(first.find("the one "), 0U) << first;
    EXPECT_NE(first.find(r.is), std::string::npos) << first;
    EXPECT_NE(first.find(r.cure), std::string::npos) << first;
    EXPECT_EQ(difference(7, with(r.habit)).find("the other "), 0U);
    EXPECT_NE(habits_text(with(r.habit)).find(r.is), std::string::npos);
    // Both have it: it is not what differs.
    EXPECT_EQ(difference(with(r.habit), with(r.habit) + 1).find(r.is), std::string::npos);
  }
  const std::string two = difference(with(Habit::kFuses) + with(Habit::kBox2dFuses), 0);
  EXPECT_NE(two.find("off; the one has a Box2D"), std::string::npos) << two;
}

TEST(Fingerprint, OtherPartsAreNamedFromTheSimplestOn) {
  EXPECT_EQ(difference(9, 9), "");
  const std::uint64_t functions = std::uint64_t{1} << kFunctionsShift;
  const std::uint64_t loners = std::uint64_t{1} << kLonersShift;
  EXPECT_EQ(difference(functions + loners + 1, 0).find("sines, cosines"), 0U);
  EXPECT_EQ(difference(loners + 1, 0).find("single bodies move differently"), 0U);
  EXPECT_EQ(difference(1, 0).find("contacts are solved in another order"), 0U);
}

TEST(Fingerprint, SeesAnotherRounding) {
  for (const int rounding : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    ASSERT_EQ(std::fesetround(rounding), 0);
    const std::uint64_t f = physics_fingerprint();
    std::fesetround(FE_TONEAREST);
    EXPECT_EQ(f >> kHabitsShift, static_cast<std::uint64_t>(Habit::kRoundsAway)) << rounding;
  }
}

// As a library does to the program that loads it, if it is linked with -ffast-math.
TEST(Fingerprint, SeesTinyNumbersTakenForNothing) {
#if defined(__x86_64__)
  const unsigned before = _mm_getcsr();
  constexpr unsigned kFlush = 0x8000;
  constexpr unsigned kDenormalsAreZero = 0x0040;
  for (const unsigned how : {kFlush, kDenormalsAreZero}) {
    _mm_setcsr(before | how);
    const std::uint64_t f = physics_fingerprint();
    _mm_setcsr(before);
    EXPECT_EQ(f >> kHabitsShift, static_cast<std::uint64_t>(Habit::kFlushes)) << how;
  }
#elif defined(__aarch64__)
  std::uint64_t before = 0;
  asm volatile("mrs %0, fpcr" : "=r"(before));
  asm volatile("msr fpcr, %0" : : "r"(before | 1U << 24U));
  const std::uint64_t f = physics_fingerprint();
  asm volatile("msr fpcr, %0" : : "r"(before));
  EXPECT_EQ(f >> kHabitsShift, static_cast<std::uint64_t>(Habit::kFlushes));
#else
  GTEST_SKIP() << "skipped: no way is known to flush on this processor";
#endif
}

}  // namespace
}  // namespace padr::world
