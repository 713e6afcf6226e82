#pragma once

#include <optional>
#include <string>
#include <vector>

namespace padr::report {

struct Options {
  std::vector<std::string> traces;
  std::string json;   ///< file, "-" for standard output, empty: none
  std::string csv;    ///< folder, empty: none
  std::string plots;  ///< likewise
};

/// Nothing if help or the version was asked for, and has been printed. Throws UserError.
std::optional<Options> parse_options(int argc, char** argv);

}  // namespace padr::report
