// Film strips: what is on them.
#include <gtest/gtest.h>

#include <algorithm>

#include "tools/lab/examples/film.h"
#include "tools/lab/examples/variant.h"
#include "tools/plot/svg.h"

namespace padr::lab::examples {
namespace {

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(Film, HasTheTruthAboveEveryBelief) {
  const plot::FilmStrip film =
      film_of(story_by_name("ball"), {{"a", without_authority().technique}, {"b", with_authority().technique}}, {});
  ASSERT_EQ(film.rows.size(), 3U);
  for (const plot::FilmRow& row : film.rows) ASSERT_EQ(row.frames.size(), film.columns.size()) << row.label;
  const auto disturbed = [](const plot::Frame& f) {
    for (const plot::Thing& t : f.things)
      if (t.role == plot::Role::kDisturbed) return true;
    return false;
  };
  EXPECT_FALSE(disturbed(film.rows[0].frames.back()));
  EXPECT_TRUE(disturbed(film.rows[1].frames.back()));
  EXPECT_FALSE(disturbed(film.rows[2].frames.back()));
}

TEST(Film, OfAStopShortBeginsItsCountAtTheModelsHit) {
  const plot::FilmStrip film = film_of(story_by_name("dominoes"), {{"a", without_authority().technique}}, {});
  EXPECT_EQ(film.columns[1], "the model hits");
  EXPECT_NE(film.rows[0].note.find("touches nothing"), std::string::npos) << film.rows[0].note;
  const auto disturbed = [](const plot::Frame& f) {
    return std::count_if(f.things.begin(), f.things.end(),
                         [](const plot::Thing& t) { return t.role == plot::Role::kDisturbed; });
  };
  EXPECT_EQ(disturbed(film.rows[1].frames[1]), 0) << "at the hit";
  EXPECT_EQ(disturbed(film.rows[1].frames.back()), 20) << "all of them lie";
}

TEST(Film, IsTheSameEveryTime) {
  const auto draw = [] {
    return plot::film_svg(film_of(story_by_name("proxy"), {{"a", with_authority().technique}}, {})).text;
  };
  const std::string svg = draw();
  EXPECT_EQ(svg, draw());
  EXPECT_EQ(count(svg, "<svg"), 1U + 2 * 5) << "the picture, and a window for every frame";
  EXPECT_EQ(count(svg, "<svg"), count(svg, "</svg>"));
  EXPECT_NE(svg.find("2 m</text>"), std::string::npos) << "scale bar";
  EXPECT_NE(svg.find("first touch</text>"), std::string::npos);
}

TEST(Svg, EscapesWordsAndKeepsNumbersShort) {
  plot::Svg svg(100, 50);
  svg.text(1, 2, "a < b & c", {});
  svg.circle({1.0 / 3, -2.0 / 3}, 4, {.fill = "#112233", .stroke = "#000000", .dashes = "3 2"});
  const std::string text = svg.text();
  EXPECT_NE(text.find(">a &lt; b &amp; c</text>"), std::string::npos) << text;
  EXPECT_NE(text.find("cx=\"0.33\" cy=\"-0.67\" r=\"4\" fill=\"#112233\""), std::string::npos) << text;
}

}  // namespace
}  // namespace padr::lab::examples
