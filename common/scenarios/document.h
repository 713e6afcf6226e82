#pragma once

#include <map>
#include <string>
#include <string_view>

#include "proto/scenario.pb.h"

namespace padr::scenarios {

/// Where in a scenario file a value stands.
struct Origin {
  std::string field;  ///< path as in `scatter[0].kind[1].radius`; empty for the file as a whole
  int line = 1;       ///< from 1
  int column = 1;     ///< from 1
};

/// A parsed scenario file, of which every single field obeys the rule that scenario.proto states for it. What takes
/// more than one field to judge (overlaps, places inside the play area) is the business of expand.h and placement.h.
class Document {
 public:
  /// `label` names the text in messages. Throws UserError for anything that is not a scenario by scenario.proto.
  Document(std::string_view text, std::string_view label);

  const padr::scenario::Scenario& scenario() const { return scenario_; }
  /// Where the field with this path stands; where its nearest given parent does if it was left to its default.
  Origin origin(std::string_view path) const;

  /// Throws UserError: "label:line:column: message".
  [[noreturn]] void fail(const Origin& where, const std::string& message) const;

 private:
  std::string label_;
  padr::scenario::Scenario scenario_;
  std::map<std::string, Origin, std::less<>> origins_;
};

}  // namespace padr::scenarios
