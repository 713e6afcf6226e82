#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace padr::plot {

/// A file to be.
struct NamedText {
  std::string name;
  std::string text;
};

/// Size and lettering of a picture.
struct Canvas {
  int width = 1000;  ///< points of the SVG; the PNG has half as many again in pixels
  int height = 640;
  int font = 14;  ///< size in points of the SVG
};

/// NAME.gp: a script that, run by gnuplot in its folder, draws the commands `body` twice, as NAME.svg and as NAME.png.
/// Sizes of points are to be multiplied by the variable `mark`, so that both look alike. Data are read with `separator`
/// between the fields and '?' for a missing value.
NamedText script(const std::string& name, const Canvas& canvas, const std::string& body,
                 std::string_view separator = "whitespace");

/// As a gnuplot string: in single quotes.
std::string in_quotes(std::string_view text);
/// For gnuplot and CSV: `digits` significant digits at most, independent of locale; '?' if not finite.
std::string number(double v, int digits = 7);

/// Makes the folder and writes the files into it. `flag` is for the message. Throws UserError if that cannot be done.
void write_into(std::string_view flag, const std::string& dir, const std::vector<NamedText>& files);

/// What came of drawing.
struct Drawing {
  std::string wrong = {};  ///< one line, such as that gnuplot is not installed, and which package has it; or empty
  bool failed = false;     ///< gnuplot is there and failed: exit code 1. Where it is not there, no picture is due
};

/// Runs gnuplot on NAME.gp in `dir` for every name, until one fails. Older pictures of these names are removed first.
/// All other files stay.
Drawing draw(const std::string& dir, const std::vector<std::string>& names);

}  // namespace padr::plot
