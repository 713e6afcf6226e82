// The table of a sweep, on rows small enough to work out by hand.
#include "tools/lab/sweep/digest.h"

#include <gtest/gtest.h>

namespace padr::lab::sweep {
namespace {

StoredRows stored() {
  StoredRows s;
  s.heading = "grid,run,of,scenario,delay_ms,seed,mean_m,avatar_mean_m,body_mean_m,peak_m,wire_kbps";
  for (const char* row : {"g,0,4,arena,0,1,1,0.5,0.5,3,10", "g,1,4,arena,0,2,3,2.3,0.7,2,20",
                          "g,2,4,arena,50,1,4,3,1,9,30", "g,3,4,arena,50,2,4,3,1,8,30"})
    s.rows.push_back({"g", s.rows.size(), 4, row, s.rows.size() + 2});
  return s;
}

TEST(Digest, TakesMeansOverSeedsAndNamesWhatIsAlikeOnce) {
  EXPECT_EQ(digest(stored()),
            "scenario arena; inconsistency in m, means over seeds, and the standard error of the mean\n"
            "delay_ms    runs     mean      +-  avatars   bodies     peak   kbit/s\n"
            "0              2    2.000   1.000    1.400    0.600     2.50     15.0\n"
            "50             2    4.000   0.000    3.000    1.000     8.50     30.0\n");
}

TEST(Digest, OfTooManyCombinationsIsANote) {
  EXPECT_EQ(digest(stored(), 1), "2 combinations: too many for a table here\n");
  EXPECT_EQ(digest({}), "");
}

TEST(Fields, AreSeparatedByCommasOutsideQuotes) {
  EXPECT_EQ(fields_of("a,\"b,\"\"c\"\"\",,d"), (std::vector<std::string>{"a", "b,\"c\"", "", "d"}));
  EXPECT_EQ(fields_of(""), (std::vector<std::string>{""}));
}

}  // namespace
}  // namespace padr::lab::sweep
