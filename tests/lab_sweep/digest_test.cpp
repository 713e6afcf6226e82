// The table of a sweep, on rows small enough to work out by hand.
#include "tools/lab/sweep/digest.h"

#include <gtest/gtest.h>

namespace padr::lab::sweep {
namespace {

StoredRows stored() {
  StoredRows s;
  s.heading = "grid,run,of,scenario,delay_ms,seed,mean_m,body_mean_m,peak_m,wire_kbps";
  for (const char* row : {"g,0,4,arena,0,1,1,0.5,3,10", "g,1,4,arena,0,2,3,0.7,2,20", "g,2,4,arena,50,1,4,1,9,30",
                          "g,3,4,arena,50,2,4,1,8,30"})
    s.rows.push_back({"g", s.rows.size(), 4, row, s.rows.size() + 2});
  return s;
}

TEST(Digest, TakesMeansOverSeedsAndNamesWhatIsAlikeOnce) {
  EXPECT_EQ(digest(stored()),
            "scenario arena; inconsistency in m, means over seeds\n"
            "delay_ms    runs     mean    (sd)    bodies     peak   kbit/s\n"
            "0              2    2.000    1.414    0.600     3.00     15.0\n"
            "50             2    4.000    0.000    1.000     9.00     30.0\n");
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
