#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/lab/figures/experiment.h"

namespace padr::lab::figures {

/// What the paper says of one of its figures, in our words, and what came out here.
struct Claim {
  std::string id = {};        ///< stable, for files and tests
  std::string figure = {};    ///< the paper's: "7", "8" or "9"
  std::string says = {};      ///< the paper
  std::string test = {};      ///< what is asked of the numbers, in one case
  std::string measured = {};  ///< means over all cases
  int holds_in = 0;           ///< cases, or cases times thresholds
  int of = 0;
  bool on_average = false;  ///< the same asked of the means over all cases
  struct Share {
    int holds_in = 0;
    int of = 0;
  };
  std::map<std::string, Share> by_kind = {};  ///< holds_in and of, by kind of input
};

/// "12 of 32", and by kind of input if there are several.
std::string share_text(const Claim& c);

/// In the order of the figures.
std::vector<Claim> judge_claims(const Plan& plan, const Results& results);

}  // namespace padr::lab::figures
