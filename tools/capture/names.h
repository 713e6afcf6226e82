#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/wire/membership_codec.h"
#include "common/wire/seal.h"
#include "common/wire/session_codec.h"

namespace padr::capture {

/// As proto/WIRE.md, section 1, calls them; empty for kNone.
std::string_view name_of(wire::SealError why);
std::string_view name_of(wire::Kind kind);
/// In lower case: join, welcome, ...
std::string_view name_of(const wire::SessionMessage& message);
std::string_view name_of(const wire::MembershipMessage& message);

/// A table for people: columns of these headings, as wide as need be. Numbers to the right, the first column to the
/// left.
class Table {
 public:
  explicit Table(std::vector<std::string> headings) : rows_{std::move(headings)} {}
  void row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  /// Each line begins with two spaces.
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

/// Fixed digits, independent of locale; "-" if not finite.
std::string fixed(double v, int digits);

}  // namespace padr::capture
