#pragma once

#include <concepts>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/model/hash.h"

namespace padr::shell {

/// "0.123" and so on: fixed digits, independent of locale; "inf" and "nan" for what is not finite.
std::string fixed(double v, int digits);
/// The same, and "-" for what is not finite.
std::string fixed_or_dash(double v, int digits);

/// "1 peer", "2 peers", for `what` whose plural ends with an s.
std::string counted(std::integral auto n, std::string_view what) {
  return std::to_string(n) + ' ' + std::string(what) + (n == 1 ? "" : "s");
}

using padr::hex;

/// `text` with every byte that is not part of well-formed UTF-8 (RFC 3629) replaced by U+FFFD. Command lines and
/// paths may hold any bytes; Json does this by itself.
std::string valid_utf8(std::string_view text);

/// `text` as a field of a CSV file, in quotes where they are needed (RFC 4180).
std::string csv_field(std::string_view text);

/// `text` as it stands in HTML, between tags or in a quoted attribute.
std::string html_escaped(std::string_view text);

/// A table for people: columns of these headings, as wide as need be. The first is flush left, the others flush right.
class Table {
 public:
  explicit Table(std::vector<std::string> headings) : rows_{std::move(headings)} {}
  void row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  /// Each line begins with two spaces.
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace padr::shell
