#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/plot/plot.h"

// What the kinds of plots share. Not for other folders.
namespace padr::plot {

/// Heights in points of the canvas, of which everything is a multiple of the letters'.
struct Rows {
  explicit Rows(const Canvas& c) : font(c.font) {}
  int font;
  int line() const { return font * 3 / 2; }  ///< of one line of text
  int foot() const { return font * 5; }      ///< numbers and label of the x axis
  int title(const std::string& text) const { return text.empty() ? 0 : font * 2; }
};

/// A horizontal key: its lines of text, and entries in one of them. Both 0 if there is nothing in it.
struct Key {
  int rows = 0;
  int columns = 0;
};
/// As wide as the canvas allows. Empty titles do not count.
Key key_of(const std::vector<std::string>& titles, const Canvas& c);

/// Of the plotting area from the canvas's edges, points: on its left there are numbers.
int left_margin(const Canvas& c);
int right_margin(const Canvas& c);

/// A plotting area `top` points below the upper edge of the canvas and `height` points high, with the canvas's margins
/// for numbers on its left.
std::string area(const Canvas& c, int top, int height);
/// The heading of an area, and between both its key. Neither takes space if empty.
std::string heading(const std::string& title, const Key& key);
/// Label, scale and range of one axis; `name` is x or y.
std::string axis(char name, const Axis& a);
/// " with lines ..." and so on, without a title.
std::string line_style(const Look& look, double width);
std::string title_clause(const std::string& title);

}  // namespace padr::plot
