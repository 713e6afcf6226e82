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
            "scenario arena; inconsistency in m, means over seeds; mean +- half of its 95 % interval\n"
            "delay_ms    runs     mean      +-  avatars   bodies     peak   kbit/s\n"
            "0              2    2.000  12.706    1.400    0.600     2.50     15.0\n"
            "50             2    4.000   0.000    3.000    1.000     8.50     30.0\n");
}

TEST(Digest, ASummaryHasEveryMeasureWithItsInterval) {
  StoredRows s = stored();
  s.heading += ",setting";
  for (StoredRow& r : s.rows) r.text += ",\"full, as is\"";
  // Means of 1 and 3, and so on; two seeds have 12.706 standard errors on either side.
  EXPECT_EQ(summary(s),
            "scenario,delay_ms,runs,mean_m,mean_m_interval,avatar_mean_m,avatar_mean_m_interval,body_mean_m,"
            "body_mean_m_interval,peak_m,peak_m_interval,wire_kbps,wire_kbps_interval\n"
            "arena,0,2,2,12.706,1.4,11.4354,0.6,1.2706,2.5,6.353,15,63.53\n"
            "arena,50,2,4,0,3,0,1,0,8.5,6.353,30,0\n");
  EXPECT_EQ(summary({}), "");
}

// Student's t for 11 degrees of freedom is 2.20099; values 0 and 1 in turn have a standard deviation of 0.52223.
TEST(Digest, IntervalsOfTwelveSeedsAreStudents) {
  StoredRows s;
  s.heading = stored().heading;
  for (std::size_t i = 0; i < 12; ++i)
    s.rows.push_back(
        {"g", i, 12,
         "g," + std::to_string(i) + ",12,arena,0," + std::to_string(i) + "," + std::to_string(i % 2) + ",0,0,0,0",
         i + 2});
  EXPECT_NE(summary(s).find("arena,0,12,0.5,0.331"), std::string::npos) << summary(s);
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
