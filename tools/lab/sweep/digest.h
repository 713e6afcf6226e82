#pragma once

#include <string>

#include "tools/lab/sweep/rows_file.h"

namespace padr::lab::sweep {

/// What a sweep's file says, for people: a table with a line for every combination of all but the seeds, of which means
/// are taken. Columns in which all rows are alike are named once above it. A note in its place if it had more than
/// `most` lines.
std::string digest(const StoredRows& stored, std::size_t most = 60);

/// Whether no row has confirmed worlds that differed.
bool agreed(const StoredRows& stored);

/// What to warn of, in one line: that some rows have an inconsistency of their first ticks alone, as the others were
/// not confirmed in time. Empty if none has. Ticks without input are not counted: the rows do not say how many there
/// are.
std::string doubt(const StoredRows& stored);

/// The same as a CSV of all measures, a line for every combination: of each measure the mean over the seeds and, in
/// MEASURE_interval, half of the 95 % interval of this mean (Student's t; 0 for a single seed). Empty without rows.
std::string summary(const StoredRows& stored);

}  // namespace padr::lab::sweep
