#include "tools/plot/palette.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace padr::plot {
namespace {

std::string in_capitals(std::string s) {
  std::transform(s.begin(), s.end(), s.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return s;
}

/// The page's hues, in order.
std::vector<std::string> page_hues() {
  std::ifstream in(PADR_PAGE_PALETTE);
  std::stringstream text;
  text << in.rdbuf();
  const std::string all = text.str();
  std::smatch list;
  std::vector<std::string> hues;
  if (!std::regex_search(all, list, std::regex(R"(const HUES = \[([^\]]*)\])"))) return hues;
  const std::string inside = list[1];
  const std::regex colour("#[0-9A-Fa-f]{6}");
  for (std::sregex_iterator i(inside.begin(), inside.end(), colour); i != std::sregex_iterator(); ++i)
    hues.push_back(in_capitals(i->str()));
  return hues;
}

/// A part of an sRGB colour, made linear, 0 to 1; `at`: of its two digits in the text.
double linear(std::string_view colour, std::size_t at) {
  const double c = std::stoi(std::string(colour.substr(at, 2)), nullptr, 16) / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

/// WCAG 2.1: relative luminance, 0 (black) to 1 (white).
double luminance(std::string_view colour) {
  return 0.2126 * linear(colour, 1) + 0.7152 * linear(colour, 3) + 0.0722 * linear(colour, 5);
}

double contrast(std::string_view a, std::string_view b) {
  const double low = std::min(luminance(a), luminance(b));
  const double high = std::max(luminance(a), luminance(b));
  return (high + 0.05) / (low + 0.05);
}

TEST(Palette, APeerHasTheSameColourOnThePageAndInThePlots) {
  const std::vector<std::string> page = page_hues();
  ASSERT_EQ(page.size(), kColours) << "no list HUES of as many colours in " << PADR_PAGE_PALETTE;
  for (std::size_t i = 0; i < kColours; ++i) EXPECT_EQ(page[i], in_capitals(std::string(colour_by_number(i)))) << i;
  EXPECT_EQ(colour_by_number(kColours), colour_by_number(0));
}

TEST(Palette, ColoursByNumberDifferAndCanBeSeenOnLightAndDark) {
  std::set<std::string_view> all;
  for (std::size_t i = 0; i < kColours; ++i) {
    all.insert(colour_by_number(i));
    EXPECT_GE(contrast(colour_by_number(i), "#FFFFFF"), 2) << colour_by_number(i) << " on the plots' white";
    EXPECT_GE(contrast(colour_by_number(i), "#1A2129"), 2) << colour_by_number(i) << " on the page's dark panels";
  }
  EXPECT_EQ(all.size(), kColours);
}

using Matrix = std::array<std::array<double, 3>, 3>;

// Machado, Oliveira and Fernandes, A Physiologically-based Model for Simulation of Color Vision Deficiency (2009),
// severity 1, on linear RGB.
constexpr Matrix kProtanopia{
    {{0.152286, 1.052583, -0.204868}, {0.114503, 0.786281, 0.099216}, {-0.003882, -0.048116, 1.051998}}};
constexpr Matrix kDeuteranopia{
    {{0.367322, 0.860646, -0.227968}, {0.280085, 0.672501, 0.047413}, {-0.011820, 0.042940, 0.968881}}};
constexpr Matrix kTritanopia{
    {{1.255528, -0.076749, -0.178779}, {-0.078411, 0.930809, 0.147602}, {0.004733, 0.691367, 0.303900}}};

std::array<double, 3> times(const Matrix& m, const std::array<double, 3>& v) {
  std::array<double, 3> out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return out;
}

/// A colour as somebody sees it, in CIELAB under D65.
std::array<double, 3> lab(std::string_view colour, const Matrix& sight) {
  constexpr Matrix kXyz{{{0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}}};
  std::array<double, 3> rgb = times(sight, {linear(colour, 1), linear(colour, 3), linear(colour, 5)});
  for (double& c : rgb) c = std::clamp(c, 0.0, 1.0);
  const auto xyz = times(kXyz, rgb);
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  const double y = f(xyz[1]);
  return {116 * y - 16, 500 * (f(xyz[0] / 0.95047) - y), 200 * (y - f(xyz[2] / 1.08883))};
}

// Once, the second and the seventh were one colour to who sees no red.
TEST(Palette, ColoursByNumberDifferForEveryColourVision) {
  for (const auto& [name, sight] :
       {std::pair{"protanopia", kProtanopia}, {"deuteranopia", kDeuteranopia}, {"tritanopia", kTritanopia}})
    for (std::size_t i = 0; i < kColours; ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const auto a = lab(colour_by_number(i), sight);
        const auto b = lab(colour_by_number(j), sight);
        EXPECT_GE(std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]), 8) << name << ": " << i << " and " << j;
      }
}

TEST(Palette, SeriesOfOnePictureHaveTheirOwnMarksAndColours) {
  const std::vector<std::string> titles{
      "avatar-only",  "fixed (m)",       "fixed, time stamps",   "full",           "full no replay",
      "full no lead", "everything",      "everything-no-replay", "rollback 60 Hz", "rollback 20 Hz",
      "somebody's",   "somebody else's", "lockstep 60 Hz",       "lockstep 20 Hz", "full --budget 8"};
  const std::vector<Look> looks = distinct_looks(titles);
  ASSERT_EQ(looks.size(), titles.size());
  std::set<std::string_view> colours;
  std::set<int> marks;
  for (std::size_t i = 0; i < titles.size(); ++i) {
    EXPECT_TRUE(colours.insert(looks[i].colour).second) << titles[i] << " has a colour that another one has";
    EXPECT_TRUE(marks.insert(looks[i].point).second) << titles[i] << " has a mark that another one has";
  }
  EXPECT_EQ(looks[3].colour, look_of("full").colour);
  EXPECT_EQ(looks[3].point, look_of("full").point);
}

TEST(Palette, MoreSeriesThanMarksAreToldApartByColour) {
  std::vector<std::string> titles;
  for (const char* known : {"avatar-only", "fixed", "adaptive", "full", "snapshot", "state-sync", "dis", "everything"})
    titles.emplace_back(known);
  for (int i = 0; i < 10; ++i) titles.push_back("unknown " + std::to_string(i));
  std::set<std::string_view> colours;
  for (const Look& look : distinct_looks(titles)) colours.insert(look.colour);
  EXPECT_EQ(colours.size(), titles.size());
}

}  // namespace
}  // namespace padr::plot
