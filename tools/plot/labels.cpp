#include "tools/plot/labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace padr::plot {
namespace {

// Distances of a label from its point. At the first it needs no line.
constexpr std::array<double, 7> kDistances{9, 20, 32, 46, 62, 80, 100};
constexpr double kMark = 6;     // half the width of a mark
constexpr double kSpace = 1.5;  // between two labels
constexpr int kRounds = 4;      // in which each label looks for a better place

// What is wrong with a place, worst first. A label that hides another cannot be read; one on a line can.
constexpr double kOutside = 1e6;
constexpr double kOnLabel = 1000;
constexpr double kOnMark = 400;
constexpr double kLineThroughLabel = 300;
constexpr double kLinesCross = 150;
constexpr double kLineThroughMark = 60;
constexpr double kOnLine = 15;

// Clockwise from where a label is looked for first, right of its point and a little above, in sixteenths of a turn.
constexpr std::array<int, 16> kDirections{1, 15, 0, 7, 9, 8, 2, 14, 3, 13, 6, 10, 5, 11, 4, 12};
// Cosines of 0 to 4 sixteenths: from a library they would differ between machines.
constexpr std::array<double, 5> kCosines{1, 0.92388, 0.70711, 0.38268, 0};

double cosine(int sixteenths) {
  const int n = sixteenths % 16 <= 8 ? sixteenths % 16 : 16 - sixteenths % 16;
  return n <= 4 ? kCosines[static_cast<std::size_t>(n)] : -kCosines[static_cast<std::size_t>(8 - n)];
}

struct Box {
  Point low;
  Point high;

  bool contains(Point p) const { return p.x > low.x && p.x < high.x && p.y > low.y && p.y < high.y; }
  Point nearest(Point p) const { return {std::clamp(p.x, low.x, high.x), std::clamp(p.y, low.y, high.y)}; }
};

Box box_of(Point centre, double width, double height) {
  return {{centre.x - width / 2, centre.y - height / 2}, {centre.x + width / 2, centre.y + height / 2}};
}

bool overlap(const Box& a, const Box& b, double space) {
  return a.low.x < b.high.x + space && b.low.x < a.high.x + space && a.low.y < b.high.y + space &&
         b.low.y < a.high.y + space;
}

using Segment = std::pair<Point, Point>;

double side(const Segment& s, Point p) {
  return (s.second.x - s.first.x) * (p.y - s.first.y) - (s.second.y - s.first.y) * (p.x - s.first.x);
}

bool cross(const Segment& a, const Segment& b) {
  return side(a, b.first) * side(a, b.second) < 0 && side(b, a.first) * side(b, a.second) < 0;
}

bool passes(const Segment& s, const Box& b) {
  return b.contains(s.first) || b.contains(s.second) || cross(s, {b.low, b.high}) ||
         cross(s, {{b.low.x, b.high.y}, {b.high.x, b.low.y}});
}

/// A label at one of its places.
struct Candidate {
  Box box;
  LabelPlace place;
  std::optional<Segment> line;
  double cost = 0;
};

Candidate candidate(const LabelRequest& label, std::size_t distance, int direction) {
  const double dx = cosine(direction);
  const double dy = -cosine(direction + 12);  // the sine
  const double r = kDistances[distance];
  Candidate c;
  c.place.centre = {label.of.x + dx * (r + label.width / 2), label.of.y + dy * (r + label.height / 2)};
  c.box = box_of(c.place.centre, label.width, label.height);
  c.place.line_end = c.box.nearest(label.of);
  c.place.apart = distance > 0;
  if (c.place.apart) c.line = Segment{label.of, c.place.line_end};
  return c;
}

bool same(Point a, Point b) {
  return std::abs(a.x - b.x) < 1 && std::abs(a.y - b.y) < 1;
}

/// What is wrong with a place whatever the other labels do.
double cost_alone(const Candidate& c, const LabelRequest& label, const Obstacles& o) {
  double cost = 0;
  if (c.box.low.x < 0 || c.box.low.y < 0 || c.box.high.x > o.width || c.box.high.y > o.height) cost += kOutside;
  for (const Point m : o.marks) {
    const Box mark = box_of(m, 2 * kMark, 2 * kMark);
    if (overlap(c.box, mark, 0)) cost += kOnMark;
    if (c.line && !same(m, label.of) && passes(*c.line, mark)) cost += kLineThroughMark;
  }
  for (const Segment& s : o.lines)
    if (passes(s, c.box)) cost += kOnLine;
  return cost;
}

double cost_beside(const Candidate& c, const Candidate& other) {
  double cost = overlap(c.box, other.box, kSpace) ? kOnLabel : 0;
  if (c.line && passes(*c.line, other.box)) cost += kLineThroughLabel;
  if (other.line && passes(*other.line, c.box)) cost += kLineThroughLabel;
  if (c.line && other.line && cross(*c.line, *other.line)) cost += kLinesCross;
  return cost;
}

std::vector<Candidate> candidates_of(const LabelRequest& label, const Obstacles& o) {
  std::vector<Candidate> all;
  for (std::size_t d = 0; d < kDistances.size(); ++d) {
    for (std::size_t i = 0; i < kDirections.size(); ++i) {
      Candidate c = candidate(label, d, kDirections[i]);
      c.cost = cost_alone(c, label, o) + kDistances[d] + static_cast<double>(i) / 2;
      all.push_back(c);
    }
  }
  return all;
}

}  // namespace

std::vector<LabelPlace> place_labels(const std::vector<LabelRequest>& labels, const Obstacles& obstacles) {
  std::vector<std::vector<Candidate>> candidates;
  candidates.reserve(labels.size());
  for (const LabelRequest& l : labels) candidates.push_back(candidates_of(l, obstacles));
  std::vector<const Candidate*> chosen(labels.size(), nullptr);
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < labels.size(); ++i) {
      double least = std::numeric_limits<double>::max();
      const Candidate* best = nullptr;
      for (const Candidate& c : candidates[i]) {
        double cost = c.cost;
        for (std::size_t k = 0; k < labels.size() && cost < least; ++k)
          if (k != i && chosen[k] != nullptr) cost += cost_beside(c, *chosen[k]);
        if (cost >= least) continue;
        least = cost;
        best = &c;
      }
      chosen[i] = best;
    }
  }
  std::vector<LabelPlace> places;
  places.reserve(chosen.size());
  for (const Candidate* c : chosen) places.push_back(c->place);
  return places;
}

}  // namespace padr::plot
