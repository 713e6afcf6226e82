#include "tools/plot/labels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace padr::plot {
namespace {

bool overlap(const LabelPlace& a, const LabelRequest& of_a, const LabelPlace& b, const LabelRequest& of_b) {
  return std::abs(a.centre.x - b.centre.x) < (of_a.width + of_b.width) / 2 &&
         std::abs(a.centre.y - b.centre.y) < (of_a.height + of_b.height) / 2;
}

/// Points, each with a label of 30 by 12, in an area of 400 by 300.
struct Crowd {
  explicit Crowd(const std::vector<Point>& points) {
    obstacles.width = 400;
    obstacles.height = 300;
    obstacles.marks = points;
    for (const Point p : points) labels.push_back({p, 30, 12});
    places = place_labels(labels, obstacles);
  }
  Obstacles obstacles;
  std::vector<LabelRequest> labels;
  std::vector<LabelPlace> places;
};

TEST(Labels, OneAloneStandsRightBesideItsPoint) {
  const Crowd c({{200, 150}});
  ASSERT_EQ(c.places.size(), 1U);
  EXPECT_FALSE(c.places[0].apart);
  EXPECT_GT(c.places[0].centre.x, 200);
  EXPECT_NEAR(c.places[0].centre.y, 150, 10);
}

TEST(Labels, OfPointsAtOnePlaceDoNotOverlap) {
  const Crowd c(std::vector<Point>(12, {200, 150}));
  bool any_apart = false;
  for (std::size_t i = 0; i < c.places.size(); ++i) {
    any_apart = any_apart || c.places[i].apart;
    for (std::size_t k = 0; k < i; ++k)
      EXPECT_FALSE(overlap(c.places[i], c.labels[i], c.places[k], c.labels[k])) << i << " and " << k;
  }
  EXPECT_TRUE(any_apart) << "so many have no room beside it";
}

TEST(Labels, HideNoMarkAndStayInTheArea) {
  const Crowd c({{2, 2}, {398, 2}, {398, 298}, {2, 298}, {200, 150}, {212, 150}, {224, 150}});
  for (std::size_t i = 0; i < c.places.size(); ++i) {
    const Point at = c.places[i].centre;
    EXPECT_TRUE(at.x >= 15 && at.x <= 385 && at.y >= 6 && at.y <= 294) << i << ": " << at.x << ", " << at.y;
    for (const Point m : c.obstacles.marks)
      EXPECT_FALSE(std::abs(at.x - m.x) < 15 && std::abs(at.y - m.y) < 6) << i << " hides " << m.x << ", " << m.y;
  }
}

TEST(Labels, NoneAreNoTrouble) {
  EXPECT_TRUE(place_labels({}, {}).empty());
}

}  // namespace
}  // namespace padr::plot
