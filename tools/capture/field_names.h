#pragma once

#include <span>
#include <string_view>

namespace padr::capture {

struct FieldName {
  std::string_view name;
  bool repeats;  ///< may come several times in one datagram
};

/// Every field of a record, in the order of CSV's columns.
std::span<const FieldName> field_names();

}  // namespace padr::capture
