#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace padr::plot {

/// How a line and its points are drawn.
struct Look {
  std::string_view colour;  ///< "#RRGGBB"
  int dash = 0;             ///< 0 solid, 1 long dashes, 2 dots, 3 dash and dot, 4 short dashes
  int point = 7;            ///< gnuplot's pointtype of pngcairo and svg, 1 .. 15
};

/// The look of a technique, the same in every picture of every program: one colour for each technique, and marks that
/// tell techniques apart without colour. Known by the beginning of the name, up to a space or the end: avatar-only,
/// fixed, adaptive, full, snapshot, state-sync, rollback, lockstep, dis, everything, everything-no-replay (also written
/// "everything
/// --replay off"); so "fixed 0.3 m" looks like fixed. Anything else is dark grey.
/// `variant`: >= 0; the same technique with other settings, such as an ablation of full or another threshold: the
/// colour stays, dashes and marks change.
Look look_of(std::string_view technique, int variant = 0);

/// Looks for the series of one picture, in their order: no two have the same mark while there are marks (15), nor the
/// same colour while there are colours (22 and more). The first series of each technique looks as look_of says unless
/// another one has that mark. What shares a technique's colour, such as an ablation, and what is not known get colours
/// of their own.
std::vector<Look> distinct_looks(const std::vector<std::string>& titles);

/// For what is not a technique: causes of updates, and peers by slot, so that a peer has one colour in every picture
/// and on the page of padr-monitor. "#RRGGBB", readable on white and on dark; again from the first after kColours.
inline constexpr std::size_t kColours = 8;
std::string_view colour_by_number(std::size_t i);
/// For what is to stay in the background of techniques: black (0), dark grey (1), grey (2), light grey (3 and up).
std::string_view shade(std::size_t i);

}  // namespace padr::plot
