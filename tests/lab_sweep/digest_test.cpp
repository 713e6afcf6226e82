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
  // Means of 1 and 3, and so on; two seeds have 12.7062 standard errors on either side.
  EXPECT_EQ(summary(s),
            "scenario,delay_ms,runs,mean_m,mean_m_interval,avatar_mean_m,avatar_mean_m_interval,body_mean_m,"
            "body_mean_m_interval,peak_m,peak_m_interval,wire_kbps,wire_kbps_interval\n"
            "arena,0,2,2,12.7062,1.4,11.4356,0.6,1.27062,2.5,6.3531,15,63.531\n"
            "arena,50,2,4,0,3,0,1,0,8.5,6.3531,30,0\n");
  EXPECT_EQ(summary({}), "");
}

/// The interval of the mean of so many values, 0 and 1 in turn, as a summary prints it.
std::string interval_of(std::size_t n) {
  StoredRows s;
  s.heading = stored().heading;
  const std::string of = std::to_string(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::string run = std::to_string(i);
    s.rows.push_back(
        {"g", i, n, "g," + run + "," + of + ",arena,0," + run + "," + std::to_string(i % 2) + ",0,0,0,0", i + 2});
  }
  const std::string key = "arena,0," + of + ",0.5,";
  const std::string text = summary(s);
  const std::size_t at = text.find(key);
  return at == std::string::npos ? text
                                 : text.substr(at + key.size(), text.find(',', at + key.size()) - at - key.size());
}

// By scipy.stats.t.ppf(0.975, n - 1): once, the third or fourth digit that is printed was wrong already.
TEST(Digest, IntervalsAreStudentsToTheLastDigitThatIsPrinted) {
  EXPECT_EQ(interval_of(4), "0.918693");
  EXPECT_EQ(interval_of(6), "0.5748");
  EXPECT_EQ(interval_of(12), "0.331811");
  EXPECT_EQ(interval_of(16), "0.275169");
  EXPECT_EQ(interval_of(18), "0.255853");
  EXPECT_EQ(interval_of(40), "0.161945");
  EXPECT_EQ(interval_of(1000), "0.0310429");
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
