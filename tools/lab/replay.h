#pragma once

#include <cstdint>
#include <string>

#include "common/trace/trace_reader.h"

namespace padr::lab {

struct ReplayResult {
  std::string difference;  ///< the first one, with its tick; empty: everything was the same
  Tick ticks = 0;          ///< replayed
  std::uint64_t confirmed = 0;
  std::uint64_t datagrams_in = 0;
  std::uint64_t datagrams_out = 0;  ///< compared byte for byte
  bool truncated = false;           ///< the trace's last record is cut off
  bool identical() const { return difference.empty(); }
};

/// Feeds a trace's inputs and received datagrams to a fresh node in the order they were recorded in, and compares what
/// it does with what was recorded: the live world's hash after every tick, what is shown, every confirmed hash, every
/// datagram sent. Stops at the first difference. Throws UserError if the trace is damaged, or is of a scenario or a
/// physics that this program does not reproduce.
ReplayResult replay(trace::TraceReader& trace);

/// `padr-lab replay TRACE`: one line on standard output with the verdict and what differs first. Returns 0 if nothing
/// does, else 1. Throws UserError.
int run_replay(const std::string& file);

}  // namespace padr::lab
