#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/scenarios/scenarios.h"
#include "tests/scenarios/support.h"

namespace padr::scenarios {
namespace {

using testing::error_of;

// A good file; each case below spoils one line of it.
const std::vector<std::string> kGood{
    /* 1 */ "name: \"test\"",
    /* 2 */ "title: \"A test\"",
    /* 3 */ "lower { x: 0 y: 0 }",
    /* 4 */ "upper { x: 10 y: 8 }",
    /* 5 */ "gravity { x: 0 y: 0 }",
    /* 6 */ "avatar {",
    /* 7 */ "  radius: 0.4 mass: 80",
    /* 8 */ "  stiffness: 40 damping: 10 max_force: 1600 max_speed: 6",
    /* 9 */ "  spawn { x: 1 y: 1 }",
    /* 10 */ "  spawn { x: 9 y: 7 }",
    /* 11 */ "}",
    /* 12 */ "walls { thickness: 1 }",
    /* 13 */ "material { friction: 0.3 linear_damping: 1 }",
    /* 14 */ "obstacle { radius: 0.5 position { x: 5 y: 7 } }",
    /* 15 */ "body { radius: 0.3 mass: 5 position { x: 3 y: 4 } }",
    /* 16 */ "body { half { x: 0.3 y: 0.2 } density: 50 position { x: 4 y: 4 } angle: 0.5 }",
    /* 17 */ "row { count: 3 step { x: 0.7 y: 0 } body { radius: 0.3 mass: 5 position { x: 3 y: 2 } } }",
    /* 18 */ "scatter {",
    /* 19 */ "  count: 5",
    /* 20 */ "  kind { radius { min: 0.1 max: 0.2 } density { min: 20 max: 30 } }",
    /* 21 */ "}",
};

std::string with_line(std::size_t line, const std::string& text) {
  std::string all;
  for (std::size_t i = 0; i < kGood.size(); ++i) all += (i + 1 == line ? text : kGood[i]) + "\n";
  return all;
}

TEST(ScenarioErrors, TheGoodFileIsGood) {
  const Scene scene = load(with_line(0, ""), "test.textproto", 1);
  EXPECT_EQ(scene.bodies.size(), 10U);
  EXPECT_EQ(scene.statics.size(), 5U);
  EXPECT_EQ(scene.bodies[0].linear_damping, 1.0F) << "the scenario's material";
  EXPECT_EQ(scene.bodies[0].restitution, 0.2F) << "the default of scenario.proto";
  EXPECT_FLOAT_EQ(scene.bodies[1].mass, 12.0F) << "50 kg/m^2 times 0.6 m x 0.4 m";
  EXPECT_EQ(scene.bodies[4].position, (Vec2{static_cast<float>(3 + 2 * 0.7), 2}));
}

struct Case {
  std::size_t line;
  std::string text;
  std::string expected;  ///< the start of the message after "test.textproto:LINE:"
};

const std::vector<Case> kCases{
    // Not in the language at all, or not of the right type.
    {15, "body { radios: 0.3 }", "14: Message type \"padr.scenario.Body\" has no field named \"radios\". (in: body"},
    {15, "body { \x95\x1b[2J", "8: Interpreting non ascii codepoint 149."},
    {15, "body { radius: big }", "16: Expected double, got: big (in: body { radius: big })"},
    {15, "body { radius: \"1\" }", "16: Expected double, got: \"1\" (in: "},
    {19, "  count: -5", "10: Expected integer, got: -, allowed: 0 or more (in: count: -5)"},
    {19, "  count: 99999999999", "10: Integer out of range (99999999999) (in: count: 99999999999)"},
    {19, "  count: 2.5", "10: Expected integer, got: 2.5 (in: count: 2.5)"},
    {5, "warm_starting: maybe", "1: Invalid value for boolean field \"warm_starting\". Value: \"maybe\". (in: "},
    {5, "gravity { x: 0 y: 0 ", "8: Message type \"padr.scenario.Vec2\" has no field named \"avatar\". (in: avatar {)"},
    {2, "name: \"again\"", "5: Non-repeated field \"name\" is specified multiple times. (in: name: \"again\")"},
    {15, "body { radius: 1 half { x: 1 y: 1 } }", "23: Field \"half\" is specified along with field \"radius\""},
    // Missing.
    {1, "", "1: name is missing"},
    {1, "name: \"\"", "1: name has 0 bytes, allowed: one line of 1 .. 64 bytes"},
    {4, "", "1: upper is missing, needed: -1000 .. 1000 m"},
    {4, "upper { x: 10 }", "1: upper.y is missing, needed: -1000 .. 1000 m"},
    {7, "  mass: 80", "1: avatar.radius is missing, needed: 0.05 .. 10 m"},
    {15, "body { mass: 5 position { x: 3 y: 4 } }", "1: body[0] has no shape, needed: radius or half"},
    {15, "body { radius: 0.3 position { x: 3 y: 4 } }", "1: body[0] has no weight, needed: mass or density"},
    {15, "body { radius: 0.3 mass: 5 }", "1: body[0].position is missing, needed: -1000 .. 1000 m"},
    {19, "", "1: scatter[0].count is missing, needed: 1 .. 5000"},
    {20, "", "1: scatter[0].kind is given 0 times, allowed: 1 .. 20 times"},
    // Out of range, each with its field, value, unit and range.
    {7, "  radius: 0 mass: 80", "3: avatar.radius is 0 m, allowed: 0.05 .. 10 m"},
    {7, "  radius: 0.4 mass: -80", "15: avatar.mass is -80 kg, allowed: 0.01 .. 100000 kg"},
    {7, "  radius: nan mass: 80", "3: avatar.radius is nan m, allowed: 0.05 .. 10 m"},
    {8, "  stiffness: inf damping: 10 max_force: 1 max_speed: 1",
     "3: avatar.stiffness is inf 1/s^2, allowed: 0.01 .. "},
    {8, "  stiffness: 40 damping: 61 max_force: 1 max_speed: 1",
     "17: avatar.damping is 61 1/s, allowed: 0.01 .. 60 1/s"},
    {8, "  stiffness: 40 damping: 6 max_force: 1 max_speed: 200",
     "41: avatar.max_speed is 200 m/s, allowed: 0.01 .. 100"},
    {5, "gravity { x: 0 y: -981 }", "16: gravity.y is -981 m/s^2, allowed: -100 .. 100 m/s^2"},
    {5, "velocity_iterations: 0", "1: velocity_iterations is 0, allowed: 1 .. 50"},
    {12, "walls { thickness: 0 }", "9: walls.thickness is 0 m, allowed: 0.1 .. 100 m"},
    {13, "material { friction: -1 }", "12: material.friction is -1, allowed: 0 .. 10"},
    {13, "material { linear_damping: 1e400 }", "12: material.linear_damping is inf 1/s, allowed: 0 .. 60 1/s"},
    {15, "body { radius: 1e-3 mass: 5 position { x: 3 y: 4 } }", "8: body[0].radius is 0.001 m, allowed: 0.05 .. 50 m"},
    {16, "body { half { x: 0.3 y: 0 } mass: 1 position { x: 4 y: 4 } }",
     "22: body[1].half.y is 0 m, allowed: 0.05 .. 50 m"},
    {16, "body { radius: 0.3 mass: 1 position { x: nan y: 4 } }",
     "39: body[1].position.x is nan m, allowed: -1000 .. "},
    {19, "  count: 0", "3: scatter[0].count is 0, allowed: 1 .. 5000"},
    {20, "  kind { radius { min: 0.3 max: 0.2 } mass { min: 1 max: 2 } }",
     "10: scatter[0].kind[0].radius has min 0.3 above max 0.2"},
    {20, "  kind { radius { min: 0 max: 0.2 } mass { min: 1 max: 2 } }",
     "19: scatter[0].kind[0].radius.min is 0 m, allowed: 0.05"},
    // What takes more than one field to judge.
    {4, "upper { x: 0.5 y: 8 }",
     "1: upper is (0.5, 8) m with lower (0, 0) m, allowed: at least 1 m right of and above"},
    {9, "  spawn { x: 1 y: -1 }",
     "3: avatar.spawn[0] at (1, -1) m is not wholly inside the play area, allowed: (0.4, 0.4)"},
    {10, "  spawn { x: 1.5 y: 1 }",
     "3: avatar.spawn[1] at (1.5, 1) m overlaps avatar.spawn[0] (line 9) at (1, 1) m by 0.3 m"},
    {10, "  spawn { x: 3 y: 4.5 }", "3: avatar.spawn[1] at (3, 4.5) m overlaps body[0] (line 15) at (3, 4) m by 0.2 m"},
    {15, "body { radius: 0.3 mass: 5 position { x: 9.9 y: 4 } }",
     "1: body[0] at (9.9, 4) m is not wholly inside the play area"},
    {15, "body { radius: 0.3 mass: 5 position { x: 5 y: 6.3 } }",
     "1: body[0] at (5, 6.3) m overlaps obstacle[0] (line 14)"},
    {15, "body { radius: 0.3 mass: 5 position { x: 4.4 y: 4 } }", "1: body[1] at (4, 4) m overlaps body[0] (line 15)"},
    {15, "body { half { x: 50 y: 50 } density: 1000 position { x: 3 y: 4 } }",
     "1: body[0] weighs 1e+07 kg by its density, allowed: 0.001 .. 1000000 kg"},
    {17, "row { count: 3 step { x: 0.5 y: 0 } body { radius: 0.3 mass: 5 position { x: 3 y: 2 } } }",
     "1: row[0] at (3.5, 2) m overlaps row[0] (line 17) at (3, 2) m by 0.1 m, allowed: 0 .. 0.005 m"},
    {17, "row { count: 5000 step { x: 1 y: 0 } body { radius: 0.3 mass: 5 position { x: 3 y: 2 } } }",
     "1: the scenario has 5007 bodies in body, row and scatter, allowed: 0 .. 5000"},
    {19, "  count: 3000", "1: scatter[0] found room for "},
    {20, "  kind { radius { min: 6 max: 6 } density { min: 1 max: 1 } }",
     "1: scatter[0] leaves no room for a body that is 12"},
    {5, "max_speed: 6.05",
     "1: max_speed is 6.05 m/s with avatar.max_speed 6 m/s, allowed: at least 1 % more than that"},
    {15, "max_speed: 7 body { radius: 0.3 mass: 5 position { x: 3 y: 4 } velocity { x: 8 y: 6 } }",
     "1: max_speed is 7 m/s with body[0].velocity 10 m/s, allowed: at least 1 % more than that"},
    {20, "  lower { x: 8 y: 8 } kind { radius { min: 0.1 max: 0.2 } mass { min: 1 max: 1 } }",
     "1: scatter[0] leaves no room"},
};

/// Some messages belong to another line than the one spoilt.
std::size_t expected_line(const Case& c) {
  const auto about = [&](const std::string& what) { return c.expected.find(what) != std::string::npos; };
  if (about("the scenario has") || about("1: name is missing") || about("1: upper is missing")) return 1;
  if (about("avatar.radius is missing") || about("no field named \"avatar\"")) return 6;
  if (about("body[1] at (4, 4)")) return 16;
  if (about("scatter[0] ") || about("scatter[0].count is missing") || about("scatter[0].kind is")) return 18;
  return c.line;
}

TEST(ScenarioErrors, EachNamesFileLineColumnFieldValueAndRange) {
  for (const Case& c : kCases) {
    const std::string message = error_of([&] { load(with_line(c.line, c.text), "test.textproto", 1); });
    const std::string expected = "test.textproto:" + std::to_string(expected_line(c)) + ":" + c.expected;
    EXPECT_EQ(message.substr(0, expected.size()), expected) << "for line " << c.line << ": " << c.text << "\n"
                                                            << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(ScenarioErrors, MaxSpeedMayBeJustAboveTheAvatars) {
  EXPECT_EQ(error_of([&] { load(with_line(5, "max_speed: 6.1"), "t", 1); }), "no error");
}

TEST(ScenarioErrors, TouchingIsNoOverlap) {
  const auto place = [](const std::string& x) {
    return error_of(
        [&] { load(with_line(15, "body { radius: 0.3 mass: 5 position { x: 3 y: " + x + " } }"), "t", 1); });
  };
  // The row's first circle, also 0.3 m, is at (3, 2).
  EXPECT_EQ(place("2.6"), "no error");
  EXPECT_EQ(place("2.596"), "no error");
  EXPECT_NE(place("2.594"), "no error");
}

TEST(ScenarioErrors, AByteOrderMarkIsNoneButUtf16Is) {
  EXPECT_EQ(error_of([&] { load("\xEF\xBB\xBF" + with_line(0, ""), "t", 1); }), "no error");
  for (const std::string mark : {"\xFF\xFE", "\xFE\xFF"})
    EXPECT_NE(error_of([&] { load(mark + with_line(0, ""), "t", 1); }).find("the file is in UTF-16, allowed: UTF-8"),
              std::string::npos);
}

TEST(ScenarioErrors, AtMost64Spawns) {
  const auto with_spawns = [](int extra) {
    std::string spawns;
    for (int i = 0; i < extra; ++i) {
      spawns += "spawn { x: " + std::to_string(1 + i % 8) + " y: " + std::to_string(i / 8) + ".5 } ";
    }
    return "name: \"t\" title: \"t\" lower { x: 0 y: 0 } upper { x: 10 y: 8 } avatar { radius: 0.4 mass: 80 stiffness: "
           "40 "
           "damping: 10 max_force: 1600 max_speed: 6 " +
           spawns + "}";
  };
  EXPECT_EQ(error_of([&] { load(with_spawns(64), "t", 1); }), "no error");
  EXPECT_NE(error_of([&] { load(with_spawns(65), "t", 1); }).find("avatar.spawn is given 65 times, allowed: 1 .. 64"),
            std::string::npos);
  EXPECT_NE(error_of([&] { load(with_spawns(0), "t", 1); }).find("avatar.spawn is given 0 times, allowed: 1 .. 64"),
            std::string::npos);
}

TEST(ScenarioErrors, FurtherSpawnsAreAsManyAsThereIsRoomForAndAtMost64InAll) {
  const auto room = [](const std::string& upper, const std::string& spawns) {
    return load("name: \"t\" title: \"t\" lower { x: 0 y: 0 } upper { " + upper +
                    " } avatar { radius: 0.4 mass: 80 stiffness: 40 damping: 10 max_force: 1600 max_speed: 6 spawn { "
                    "x: 1 "
                    "y: 1 } " +
                    spawns + "}",
                "t", 1)
        .avatar.spawns.size();
  };
  EXPECT_EQ(room("x: 30 y: 20", "more_spawns: 63"), 64U);
  EXPECT_EQ(room("x: 2 y: 2", "more_spawns: 63"), 1U);
  EXPECT_NE(error_of([&] {
              room("x: 30 y: 20", "spawn { x: 5 y: 5 } more_spawns: 63");
            }).find("avatar.more_spawns is 63 beside 2 listed, allowed: 64 in all"),
            std::string::npos);
}

TEST(ScenarioErrors, NoTextIsTooStrange) {
  for (const std::string& text :
       {std::string(), std::string("\0\0\0", 3), std::string("\xFF\xFE"), std::string(9U << 20U, ' '),
        std::string(100000, '{'), std::string("name: \"a\nb\""), std::string("# only this")}) {
    const std::string message = error_of([&] { load(text, "odd", 1); });
    EXPECT_EQ(message.substr(0, 4), "odd:") << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_LT(message.size(), 400U);
  }
}

TEST(ScenarioErrors, EveryTruncationOfABuiltInFileIsRefusedOrLoads) {
  const std::string text(embedded_text("proxy"));
  for (std::size_t n = 0; n < text.size(); ++n) {
    const std::string message = error_of([&] { load(text.substr(0, n), "cut", 1); });
    EXPECT_TRUE(message == "no error" || message.starts_with("cut:")) << message;
  }
}

}  // namespace
}  // namespace padr::scenarios
