#pragma once

#include <string>
#include <vector>

#include "common/model/technique.h"

namespace padr::lab::examples {

/// A technique to be judged by what its model errors do to bodies.
struct Variant {
  std::string label;  ///< for tables: "adaptive, pcc"
  std::string flags;  ///< that make it: "adaptive --predictor pcc"
  Technique technique;
  std::string predictor = {};  ///< that adapts the threshold, by name; empty: the threshold is fixed, or as full has it
};

/// The paper's means one by one: without authority and with it, in each case with a fixed threshold of 0.8 m and with
/// 0.8 m / 0.3 m adapted by each predictor; adaptive without the update at the end of contacts, without the recursion
/// into bodies touched by proxy, and without both; and full.
std::vector<Variant> variants();

/// The two that films and the series of dominoes compare, both among variants().
Variant without_authority();
Variant with_authority();

}  // namespace padr::lab::examples
