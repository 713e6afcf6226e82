#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/scenarios/path.h"
#include "tests/scenarios/support.h"

namespace padr::scenarios {
namespace {

using testing::error_of;

TEST(PathCsv, ReadsWhatPeopleAndTheirToolsWrite) {
  const std::vector<PathPoint> expected{{0, {1, 2}}, {0.5, {-3.25F, 4}}, {2, {5, 1e-3F}}};
  for (const std::string& text : {
           std::string("t,x,y\n0,1,2\n0.5,-3.25,4\n2,5,0.001\n"),
           std::string("0,1,2\n0.5,-3.25,4\n2,5,0.001"),
           std::string("\xEF\xBB\xBFt,x,y\r\n0,1,2\r\n0.5,-3.25,4\r\n2,5,1e-3\r\n\r\n\r\n"),
           std::string("# recorded by hand\n t , x , y \n  # indented\n0,\t1, 2 \n0.50,-3.25,4.0\n\n2,5,1E-3\n# end"),
       }) {
    EXPECT_EQ(parse_path_csv(text, "p.csv").points(), expected) << text;
  }
}

struct Spoilt {
  std::string text;
  std::string expected;
};

TEST(PathCsv, ErrorsNameFileLineColumnAndWhatIsAllowed) {
  const std::vector<Spoilt> cases{
      {"", "p.csv:1:1: the file ends after 0 rows, allowed: at least 2 rows t,x,y"},
      {"t,x,y\n", "p.csv:2:1: the file ends after 0 rows, allowed: at least 2 rows t,x,y"},
      {"t,x,y\n0,1,2\n", "p.csv:3:1: the file ends after 1 rows, allowed: at least 2 rows t,x,y"},
      {"t,y,x\n0,1,2\n", "p.csv:1:3: \"y\" in the first line, allowed: the header t,x,y or a row of numbers"},
      {"time,x,y\n0,1,2\n", "p.csv:1:1: \"time\" in the first line, allowed: the header t,x,y or a row of numbers"},
      {"t,x,y\nt,x,y\n", "p.csv:2:1: t is \"t\", not a number, allowed: -10000000000 .. 10000000000 s"},
      {"0\n1\n", "p.csv:1:2: x is missing, allowed: the three columns t,x,y"},
      {"0,1\n1,2\n", "p.csv:1:4: y is missing, allowed: the three columns t,x,y"},
      {"0,1,2,3\n", "p.csv:1:7: a fourth column, allowed: the three columns t,x,y"},
      {"0,1,2,\n", "p.csv:1:7: a fourth column, allowed: the three columns t,x,y"},
      {"0;1;2\n", "p.csv:1:6: x is missing, allowed: the three columns t,x,y"},
      {"0,1,2\n0.1,nan,2\n", "p.csv:2:5: x is \"nan\", allowed: -10000 .. 10000 m"},
      {"0,1,2\ninf,1,2\n", "p.csv:2:1: t is \"inf\", allowed: -10000000000 .. 10000000000 s"},
      {"nan,1,2\n", "p.csv:1:1: t is \"nan\", allowed: -10000000000 .. 10000000000 s"},
      {"0,1,2\n0.1,1,1e99\n", "p.csv:2:7: y is \"1e99\", allowed: -10000 .. 10000 m"},
      {"0,1,2\n0.1, 10000.5,0\n", "p.csv:2:6: x is \"10000.5\", allowed: -10000 .. 10000 m"},
      {"0,1,2\n0.1,1.2.3,0\n", "p.csv:2:5: x is \"1.2.3\", not a number, allowed: -10000 .. 10000 m"},
      {"0,1,2\n0.1,,0\n", "p.csv:2:5: x is \"\", not a number, allowed: -10000 .. 10000 m"},
      {"0,1,2\n0.1,1 2,0\n", "p.csv:2:5: x is \"1 2\", not a number, allowed: -10000 .. 10000 m"},
      {"0,1,2\n0.1,0x1p3,0\n", "p.csv:2:5: x is \"0x1p3\", not a number, allowed: -10000 .. 10000 m"},
      {"0,1,2\n0,1,2\n", "p.csv:2:1: t is 0 s, allowed: more than 0 s, the t of the row before"},
      {"1,1,2\n\n0.5,1,2\n", "p.csv:3:1: t is 0.5 s, allowed: more than 1 s, the t of the row before"},
  };
  for (const Spoilt& c : cases) {
    EXPECT_EQ(error_of([&] { parse_path_csv(c.text, "p.csv"); }), c.expected) << c.text;
  }
}

TEST(PathCsv, QuotesLittleOfABinaryFile) {
  const std::string message = error_of([] { parse_path_csv(std::string(1U << 20U, '\x01') + ",1,2", "p.csv"); });
  EXPECT_TRUE(message.starts_with("p.csv:1:1: \"????")) << message.substr(0, 80);
  EXPECT_LT(message.size(), 200U);
}

TEST(PathCsv, AMillionRowsAndNotOneMore) {
  std::string text;
  for (int i = 0; i < 1'000'000; ++i) text += std::to_string(i) + ",0,0\n";  // all of them accepted
  EXPECT_EQ(error_of([&] { parse_path_csv(text + "1000000,0,0\n", "p.csv"); }),
            "p.csv:1000001:1: one row too many, allowed: at most 1000000 rows");
}

Path random_path() {
  const auto moments =
      *rc::gen::suchThat(rc::gen::unique<std::vector<double>>(
                             rc::gen::map(rc::gen::arbitrary<double>(), [](double v) { return std::fmod(v, 1e10); })),
                         [](const std::vector<double>& v) { return v.size() >= 2; });
  std::vector<double> sorted = moments;
  std::sort(sorted.begin(), sorted.end());
  std::vector<PathPoint> points;
  for (const double t : sorted) {
    const auto metres = rc::gen::map(rc::gen::arbitrary<float>(), [](float v) { return std::fmod(v, 10000.0F); });
    points.push_back({t, {*metres, *metres}});
  }
  return Path(points);
}

TEST(PathCsv, WhatIsWrittenReadsBackToTheBit) {
  EXPECT_TRUE(rc::check("parse(write(path)) == path", [] {
    const Path path = random_path();
    RC_ASSERT(parse_path_csv(write_path_csv(path), "p.csv").points() == path.points());
  }));
  const Path extremes({{-1e10, {-10000, 10000}}, {0.1 + 0.2, {0.1F, 1e-38F}}, {1e10, {1e-45F, 9999.999F}}});
  EXPECT_EQ(parse_path_csv(write_path_csv(extremes), "p.csv").points(), extremes.points());
}

TEST(Path, RunsStraightBetweenItsPointsFromTheFirstOn) {
  const Path path({{100, {0, 0}}, {101, {2, 4}}, {103, {2, 0}}});
  EXPECT_EQ(path.duration(), 3);
  EXPECT_EQ(path.at(-5, false), (Vec2{0, 0}));
  EXPECT_EQ(path.at(0, false), (Vec2{0, 0}));
  EXPECT_EQ(path.at(0.25, false), (Vec2{0.5F, 1}));
  EXPECT_EQ(path.at(1, false), (Vec2{2, 4}));
  EXPECT_EQ(path.at(2, false), (Vec2{2, 2}));
  EXPECT_EQ(path.at(3, false), (Vec2{2, 0}));
  EXPECT_EQ(path.at(1e9, false), (Vec2{2, 0}));
}

TEST(Path, LoopsFromItsEndToItsBeginning) {
  const Path path({{100, {0, 0}}, {101, {2, 4}}, {103, {2, 0}}});
  EXPECT_EQ(path.at(2, true), (Vec2{2, 2}));
  EXPECT_EQ(path.at(3, true), (Vec2{0, 0}));
  EXPECT_EQ(path.at(3.25, true), (Vec2{0.5F, 1}));
  EXPECT_EQ(path.at(3000.25, true), (Vec2{0.5F, 1}));
}

TEST(Path, NeverLeavesTheBoxOfItsPoints) {
  EXPECT_TRUE(rc::check("lowest <= at(t) <= highest", [] {
    const Path path = random_path();
    const double seconds = *rc::gen::map(rc::gen::arbitrary<double>(), [](double v) { return std::fmod(v, 1e10); });
    const Vec2 p = path.at(seconds, *rc::gen::arbitrary<bool>());
    Vec2 low = path.points()[0].position;
    Vec2 high = low;
    for (const PathPoint& q : path.points()) {
      low = {std::min(low.x, q.position.x), std::min(low.y, q.position.y)};
      high = {std::max(high.x, q.position.x), std::max(high.y, q.position.y)};
    }
    RC_ASSERT(p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y);
  }));
}

}  // namespace
}  // namespace padr::scenarios
