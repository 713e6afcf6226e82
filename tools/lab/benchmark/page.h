#pragma once

#include <string>
#include <vector>

#include "tools/lab/compare/comparison.h"

namespace padr::lab::benchmark {

/// The page of results as HTML: how it was measured, then for each network the picture `frontier_NETWORK.svg` beside it
/// and a table; what sends no more than `full` and is less wrong stands out.
std::string page(const std::vector<compare::Row>& rows, const compare::Plan& plan, const std::string& command,
                 const std::string& id);

}  // namespace padr::lab::benchmark
