#pragma once

#include "common/sync/fold.h"
#include "common/trace/metrics.h"

namespace padr::trace {

/// The agreed word on a confirmed tick. Without dynamic authority nobody owns a body.
Truth truth_of(const sync::FoldState& confirmed, bool authority);
/// The same, into memory that is used again.
void take_truth(const sync::FoldState& confirmed, bool authority, Truth& out);

}  // namespace padr::trace
