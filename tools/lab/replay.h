#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/replica/replica.h"
#include "common/trace/trace_reader.h"

namespace padr::lab {

struct ReplayResult {
  std::string difference;  ///< the first one, with its tick; empty: everything was the same
  Tick ticks = 0;          ///< replayed
  std::uint64_t confirmed = 0;
  std::uint64_t datagrams_in = 0;
  std::uint64_t datagrams_out = 0;  ///< compared byte for byte
  bool truncated = false;           ///< the trace's last record is cut off
  bool has_rest = false;            ///< bytes follow its end that are no record
  bool identical() const { return difference.empty(); }
};

/// Feeds a trace's inputs and received datagrams to a fresh replica in the order they were recorded in, and compares
/// what it does with what was recorded: the live world's hash after every tick, what is shown, every confirmed hash,
/// every datagram sent. Stops at the first difference.
class Replay {
 public:
  /// `trace` must outlive it. `on_confirmed` sees what the replica confirms, and may be empty. Throws UserError if the
  /// trace is of a scenario or a physics that this program does not reproduce.
  explicit Replay(trace::TraceReader& trace, node::Replica::ConfirmedSink on_confirmed = {});
  ~Replay();
  Replay(const Replay&) = delete;
  Replay& operator=(const Replay&) = delete;

  /// What the trace has next, after the replica has done it; nothing at the end, and after a difference. Spans in it
  /// hold until the next call. Throws UserError if the trace is damaged.
  std::optional<trace::Event> next();

  const Scene& scene() const;
  /// Null before the trace has said what it begins with.
  const node::Replica* replica() const;
  /// Who came and went, as the replica has it, since the last call.
  std::vector<node::MemberChange> take_changes();
  const ReplayResult& result() const;

 private:
  class Again;
  trace::TraceReader& trace_;
  std::unique_ptr<Again> again_;
};

/// All of a trace. Throws UserError as Replay does.
ReplayResult replay(trace::TraceReader& trace);

/// A whole trace file, of hours of a busy session at most. Throws UserError, which calls it TRACE.
std::string read_trace_file(const std::string& file);

/// `padr-lab replay TRACE`: one line on standard output with the verdict and what differs first. Returns 0 if nothing
/// does, else 1. Throws UserError.
int run_replay(const std::string& file);

}  // namespace padr::lab
