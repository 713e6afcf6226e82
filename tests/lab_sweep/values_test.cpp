// Lists as flags take them.
#include "tools/lab/sweep/values.h"

#include <gtest/gtest.h>

#include "tests/lab_sweep/error_of.h"

namespace padr::lab::sweep {
namespace {

using test::error_of;
using Numbers = std::vector<std::uint64_t>;
using Reals = std::vector<double>;

TEST(Integers, AreNumbersAndRanges) {
  EXPECT_EQ(integers_of("--x", "3", 0, 9), (Numbers{3}));
  EXPECT_EQ(integers_of("--x", "1-4,9,6-6", 0, 9), (Numbers{1, 2, 3, 4, 9, 6}));
  EXPECT_EQ(integers_of("--x", "18446744073709551615", 0, ~0ULL), (Numbers{~0ULL}));
}

TEST(Integers, OutsideTheRangeAreRefused) {
  EXPECT_EQ(integers_of("--x", "2,9", 2, 9), (Numbers{2, 9}));
  for (const char* bad : {"1", "10", "2-10", "5-4", "-1", "2.5", "x", "2-", ""})
    EXPECT_NE(error_of([&] { integers_of("--x", bad, 2, 9); }).find("--x: '"), std::string::npos) << bad;
  EXPECT_EQ(error_of([] { integers_of("--x", "10", 2, 9); }),
            "--x: '10' is not allowed; give whole numbers from 2 to 9, or ranges such as 1-20");
}

TEST(Lists, HaveNoEmptyPlacesAndNothingTwice) {
  for (const char* bad : {"", ",", "a,", ",a", "a,,b", "a,b,a"})
    EXPECT_NE(error_of([&] { words_of("--x", bad); }), "no error") << bad;
  EXPECT_EQ(error_of([] { integers_of("--x", "1-3,2", 0, 9); }), "--x: '1-3,2' is not allowed; give every value once");
  EXPECT_EQ(error_of([] { milliseconds_of("--x", "0.1s,100ms"); }),
            "--x: '0.1s,100ms' is not allowed; give every value once");
}

TEST(Times, WithoutAUnitTakeTheNextOne) {
  EXPECT_EQ(milliseconds_of("--x", "0,50,100ms"), (Reals{0, 50, 100}));
  EXPECT_EQ(milliseconds_of("--x", "500us,1,2s"), (Reals{0.5, 1000, 2000}));
  EXPECT_EQ(milliseconds_of("--x", "0"), (Reals{0}));
  EXPECT_EQ(milliseconds_of("--x", "60s"), (Reals{60'000}));
}

TEST(Times, WithoutAnyUnitOrTooLongAreRefused) {
  for (const char* bad : {"50", "50ms,3", "61s", "-1ms", "nanms", "ms", "5min"})
    EXPECT_NE(error_of([&] { milliseconds_of("--x", bad); }).find("times from 0 to 60 s"), std::string::npos) << bad;
}

TEST(Percents, MayHaveTheirSign) {
  EXPECT_EQ(percents_of("--x", "0,2.5,10%"), (Reals{0, 2.5, 10}));
  EXPECT_EQ(percents_of("--x", "100%"), (Reals{100}));
  for (const char* bad : {"101", "-1", "nan", "%", "5%%"})
    EXPECT_NE(error_of([&] { percents_of("--x", bad); }).find("from 0 to 100"), std::string::npos) << bad;
}

}  // namespace
}  // namespace padr::lab::sweep
