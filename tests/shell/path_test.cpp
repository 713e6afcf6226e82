#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/scenarios/path.h"
#include "shell/path_csv.h"
#include "shell/path_survey.h"
#include "tests/scenarios/support.h"

namespace padr::scenarios {
namespace {

using shell::fit_path;
using shell::notes_on_path;
using shell::parse_path_csv;
using shell::PathNotes;
using shell::PathUnits;
using shell::survey_path;
using shell::write_path_csv;
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
      {"t,x,y\n0,1,2\n", "p.csv:3:1: the file ends after 1 row, allowed: at least 2 rows t,x,y"},
      {"t,y,x\n0,1,2\n", "p.csv:1:3: \"y\" in the first line, allowed: the header t,x,y or a row of numbers"},
      {"time,x,y\n0,1,2\n", "p.csv:1:1: \"time\" in the first line, allowed: the header t,x,y or a row of numbers"},
      {"t,x,y\nt,x,y\n", "p.csv:2:1: t is \"t\", not a number, allowed: -10000000000 .. 10000000000 s"},
      {"0\n1\n", "p.csv:1:2: x is missing, allowed: the three columns t,x,y"},
      {"0,1\n1,2\n", "p.csv:1:4: y is missing, allowed: the three columns t,x,y"},
      {"0,1,2,3\n", "p.csv:1:7: a fourth column, allowed: the three columns t,x,y, and a row on each line"},
      {"0,1,2,\n", "p.csv:1:7: a fourth column, allowed: the three columns t,x,y, and a row on each line"},
      {"0;1;2\n", "p.csv:1:2: a semicolon, allowed: commas between the three columns t,x,y, and a row on each line"},
      {"t\tx\ty\n", "p.csv:1:2: a tab, allowed: commas between the three columns t,x,y, and a row on each line"},
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

TEST(PathCsv, TimesInMillisecondsAndSeveralRowsOfOne) {
  const PathUnits units{1000, "ms", "px", true};
  EXPECT_EQ(parse_path_csv("t,x,y\n1700000000000,100,50\n1700000000000,200,60\n1700000000500,300,70\n", "p.csv", units)
                .points(),
            (std::vector<PathPoint>{{1.7e9, {200, 60}}, {1700000000.5, {300, 70}}}));
  EXPECT_EQ(error_of([&] { parse_path_csv("5,1,2\n4,1,2\n", "p.csv", units); }),
            "p.csv:2:1: t is 4 ms, allowed: more than 5 ms, the t of the row before");
  EXPECT_EQ(error_of([&] { parse_path_csv("5,1e9,2\n", "p.csv", units); }),
            "p.csv:1:3: x is \"1e9\", allowed: -10000 .. 10000 px");
}

Scene room() {
  Scene s;
  s.lower = {0, 0};
  s.upper = {20, 15};
  s.avatar.radius = 0.5F;
  s.avatar.max_speed = 6;
  return s;
}

TEST(PathSurvey, SaysWhatThePathAsksForAndWarnsOfOtherUnits) {
  const PathNotes good = notes_on_path(Path({{5, {1, 2}}, {6, {4, 2}}, {7, {4, 6}}}), "p.csv", room());
  EXPECT_EQ(good.summary,
            "path p.csv: 3 points in 2 s, x 1 .. 4 m, y 2 .. 6 m, up to 4 m/s; the world: x 0 .. 20 m, y 0 .. 15 m, "
            "avatars make up to 6 m/s");
  EXPECT_TRUE(good.warnings.empty());
  const std::string hint = "; padr-lab path fits paths in pixels and milliseconds to a scenario";
  // Pixels and milliseconds, as they are.
  EXPECT_EQ(notes_on_path(Path({{0, {100, 10}}, {1000, {800, 10}}, {2000, {800, 10}}}), "p.csv", room()).warnings,
            (std::vector<std::string>{"path p.csv: 3 of its 3 points are outside the world (x 0 .. 20 m, y 0 .. 15 m)" +
                                      hint}));
  EXPECT_EQ(
      notes_on_path(Path({{0, {1, 1}}, {1000, {8, 1}}}), "p.csv", room()).warnings,
      (std::vector<std::string>{"path p.csv: it hardly moves, at most 0.007 m/s; are its times milliseconds?" + hint}));
  // A pointer that flicks goes fast even if its milliseconds count as seconds.
  std::vector<PathPoint> flicks;
  for (int i = 0; i < 100; ++i) flicks.push_back({28.0 * i, {i % 2 == 0 ? 1.0F : 4.0F, 2}});
  EXPECT_EQ(notes_on_path(Path(std::move(flicks)), "p.csv", room()).warnings,
            (std::vector<std::string>{"path p.csv: its points are 28 s apart on average; are its times milliseconds?" +
                                      hint}));
  // A corner is a part of the world; nobody gets 6.1 m in a second.
  EXPECT_TRUE(notes_on_path(Path({{0, {0, 15}}, {1, {6, 15}}}), "p.csv", room()).warnings.empty());
  EXPECT_EQ(notes_on_path(Path({{0, {0, 15}}, {1, {6.1F, 15}}, {2, {6.1F, 15}}}), "p.csv", room()).warnings,
            (std::vector<std::string>{
                "path p.csv: at 1 of its 3 points it asks for more than an avatar can do: up to "
                "6.1 m/s, but an avatar reaches only 6 m/s; padr-lab path --stretch 1.1 makes it slow enough"}));
}

// Once, the last second did not count: the first of these hardly moved, and the second kept to a walk.
TEST(PathSurvey, ARushAtTheEndCounts) {
  for (const std::vector<PathPoint>& rush : {std::vector<PathPoint>{{0, {3, 7}}, {1, {3, 7}}, {1.2, {14, 7}}},
                                             std::vector<PathPoint>{{0, {3, 7}}, {1, {4, 7}}, {1.01, {14, 7}}}}) {
    EXPECT_GE(survey_path(Path(rush), room()).fastest, 10);
    const PathNotes notes = notes_on_path(Path(rush), "p.csv", room());
    ASSERT_EQ(notes.warnings.size(), 1U);
    EXPECT_NE(notes.warnings[0].find("more than an avatar can do"), std::string::npos) << notes.warnings[0];
  }
}

// Once, it named a stretch that padr-lab path refuses.
TEST(PathSurvey, APathThatNoStretchSlowsDownIsToldSo) {
  const Path leap({{0, {0, 15}}, {0.0001, {19, 15}}, {2, {19, 15}}});
  const std::string warning = notes_on_path(leap, "p.csv", room()).warnings.at(0);
  EXPECT_NE(warning.find("not even padr-lab path --stretch 1000 makes it slow enough"), std::string::npos) << warning;
}

// Two rushes with a rest between them: a second holds more of a rush that takes longer.
TEST(PathSurvey, TheStretchThatItNamesIsEnough) {
  const std::vector<PathPoint> rushes{{0, {1, 1}}, {0.5, {7, 1}}, {1.2, {7, 1}}, {1.7, {14, 1}}, {3, {14, 1}}};
  const std::string warning = notes_on_path(Path(rushes), "p.csv", room()).warnings.at(0);
  const std::size_t at = warning.find("--stretch ");
  ASSERT_NE(at, std::string::npos) << warning;
  const double stretch = std::stod(warning.substr(at + 10));
  EXPECT_GT(stretch, 1.1);
  std::vector<PathPoint> slow = rushes;
  for (PathPoint& p : slow) p.seconds *= stretch;
  EXPECT_TRUE(notes_on_path(Path(slow), "p.csv", room()).warnings.empty()) << warning;
}

TEST(PathSurvey, TrembleIsNoSpeed) {
  std::vector<PathPoint> points;
  for (int i = 0; i <= 400; ++i)
    points.push_back({i / 200.0, {10 + (i % 2 == 0 ? 0.0F : 0.1F), 5 + 0.01F * static_cast<float>(i)}});
  EXPECT_NEAR(survey_path(Path(points), room()).fastest, 2, 0.1) << "20 m/s from one point to the next";
}

TEST(FitPath, FillsTheWorldAsFarAsItGoesTheRightWayUp) {
  // A window of 1000 by 300 pixels: the width decides.
  const Path path({{50, {0, 0}}, {51, {1000, 0}}, {53, {1000, 300}}});
  const std::vector<PathPoint> turned = fit_path(path, "p.csv", room(), true).points();
  EXPECT_EQ(turned[0], (PathPoint{0, {0.5F, 7.5F + 2.85F}}));
  EXPECT_EQ(turned[1], (PathPoint{1, {19.5F, 7.5F + 2.85F}}));
  EXPECT_EQ(turned[2], (PathPoint{3, {19.5F, 7.5F - 2.85F}}));
  EXPECT_EQ(fit_path(path, "p.csv", room(), false).points()[0].position, (Vec2{0.5F, 7.5F - 2.85F}));
  EXPECT_EQ(fit_path(Path({{0, {3, 3}}, {1, {3, 9}}}), "p.csv", room(), false).points()[1].position, (Vec2{10, 14.5F}));
  EXPECT_EQ(error_of([] {
              fit_path(Path({{0, {3, 3}}, {1, {3, 3}}}), "p.csv", room(), true);
            }),
            "p.csv: all points are in one place, allowed: a path that moves");
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
