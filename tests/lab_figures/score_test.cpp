// What counts as a warning, as one that came true, and as a contact that was foreseen: tick by tick, by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tools/lab/figures/score.h"

namespace padr::lab::figures {
namespace {

/// One letter a tick: '.' nothing, 'w' predicted, 'T' touching, 'B' both.
PredictionScore score(const std::string& story, Tick horizon) {
  std::vector<bool> predicted;
  std::vector<bool> touching;
  for (const char c : story) {
    predicted.push_back(c == 'w' || c == 'B');
    touching.push_back(c == 'T' || c == 'B');
  }
  return score_predictions(predicted, touching, horizon);
}

const std::string kCalm(kFreeTicks, '.');

struct Row {
  const char* what;
  std::string story;
  int right, wrong, foreseen, unforeseen;
};

TEST(PredictionScore, WarningsAndContacts) {
  const std::vector<Row> rows{
      {"a warning up to the contact", "..wwwT" + kCalm, 1, 0, 1, 0},
      {"a contact out of nothing", kCalm + "T" + kCalm, 0, 0, 0, 1},
      {"a warning and nothing", "..www....." + kCalm, 0, 1, 0, 0},
      {"true at the horizon, but it stood no more when the contact came", "..www...T" + kCalm, 1, 0, 0, 1},
      {"one tick beyond the horizon", "..www....T" + kCalm, 0, 1, 0, 1},
      {"two warnings, one of which came too early", "ww......wwT" + kCalm, 1, 1, 1, 0},
      {"too close to the end to tell", kCalm + "www...", 0, 0, 0, 0},
      {"just long enough to tell", kCalm + "www....", 0, 1, 0, 0},
      {"still warning at the end", kCalm + "www", 0, 0, 0, 0},
      {"predicted while touching is no warning", "TBBBT" + kCalm, 0, 0, 0, 1},
      {"off and on again is one contact", "wwT....T" + kCalm, 1, 0, 1, 0},
      {"off for long enough is two", "wwT" + kCalm + "T" + kCalm, 1, 0, 1, 1},
  };
  for (const Row& r : rows) {
    const PredictionScore s = score(r.story, 4);
    EXPECT_EQ(s.right, r.right) << r.what;
    EXPECT_EQ(s.wrong, r.wrong) << r.what;
    EXPECT_EQ(s.foreseen, r.foreseen) << r.what;
    EXPECT_EQ(s.unforeseen, r.unforeseen) << r.what;
  }
}

TEST(PredictionScore, SharesAndLead) {
  PredictionScore s = score("..wwwwwwT" + kCalm, 4);
  EXPECT_EQ(s.precision(), 1);
  EXPECT_EQ(s.recall(), 1);
  EXPECT_DOUBLE_EQ(s.lead_s(), 6.0 / kTicksPerSecond);
  EXPECT_DOUBLE_EQ(s.warned_share(), 6.0 / (8 + kFreeTicks));
  s += score(kCalm + "T", 4);
  EXPECT_EQ(s.recall(), 0.5);
  EXPECT_EQ(s.precision(), 1);
  EXPECT_TRUE(std::isnan(score(kCalm, 4).precision()));
  EXPECT_TRUE(std::isnan(score(kCalm, 4).recall()));
}

}  // namespace
}  // namespace padr::lab::figures
