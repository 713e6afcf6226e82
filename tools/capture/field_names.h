#pragma once

#include <string_view>
#include <vector>

namespace padr::capture {

struct FieldName {
  std::string_view name;
  bool repeats;  ///< may come several times in one datagram
};

/// Every field of a record, in the order of CSV's columns.
const std::vector<FieldName>& field_names();

}  // namespace padr::capture
