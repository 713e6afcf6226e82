#pragma once

#include <span>

#include "tools/lab/compare/trial.h"

namespace padr::lab::compare {

/// A figure of a score, as JSON and CSV name it. Processor time is none of them: it differs from run to run.
struct Field {
  const char* name;
  double (*of)(const Score&);
  void (*put)(Score&, double);
  bool (*has)(const Score&) = has_any;  ///< whether it counts in means over seeds
};

/// All there are, in the order of columns.
std::span<const Field> fields();

/// The column of Score::processor_steps.
inline constexpr const char* kProcessorColumn = "processor_steps";

}  // namespace padr::lab::compare
