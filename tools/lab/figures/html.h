#pragma once

#include <string>
#include <vector>

#include "tools/lab/figures/claims.h"

namespace padr::lab::figures {

/// One page with everything: claims beside what was measured, and, if `pictures`, the SVG files of `dir` within it. It
/// needs no other file and no network. Throws UserError if a picture cannot be read.
std::string html(const std::string& dir, const Plan& plan, const Results& results, const std::vector<Claim>& claims,
                 bool pictures);

}  // namespace padr::lab::figures
