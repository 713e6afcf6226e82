#include "common/scenarios/bodies.h"

#include <google/protobuf/text_format.h>

#include "common/scenarios/document.h"

namespace padr::scenarios {
namespace {

std::uint64_t bodies_of(const padr::scenario::Scenario& s) {
  auto all = static_cast<std::uint64_t>(s.body_size());
  for (const auto& block : s.row()) all += block.count();
  for (const auto& block : s.scatter()) all += block.count();
  return all;
}

}  // namespace

std::string with_bodies(std::string_view text, std::string_view label, std::uint32_t bodies) {
  const Document document(text, label);
  padr::scenario::Scenario changed = document.scenario();
  const bool scattered = changed.scatter_size() > 0;
  if (!scattered && changed.row_size() == 0)
    document.fail(document.origin(""), "has neither a scatter nor a row block whose count could be changed");
  const std::uint32_t now = scattered ? changed.scatter().rbegin()->count() : changed.row().rbegin()->count();
  const std::uint64_t others = bodies_of(changed) - now;
  if (bodies <= others)
    document.fail(document.origin(""), "cannot have " + std::to_string(bodies) + " bodies, allowed: more than the " +
                                           std::to_string(others) + " that are not of its last " +
                                           (scattered ? "scatter" : "row") + " block");
  const auto count = static_cast<std::uint32_t>(bodies - others);
  if (scattered) {
    changed.mutable_scatter(changed.scatter_size() - 1)->set_count(count);
  } else {
    changed.mutable_row(changed.row_size() - 1)->set_count(count);
  }
  std::string out;
  google::protobuf::TextFormat::PrintToString(changed, &out);
  return out;
}

}  // namespace padr::scenarios
