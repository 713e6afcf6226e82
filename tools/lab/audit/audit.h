#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tools/lab/audit/evidence.h"
#include "tools/lab/audit/finding.h"

namespace padr::lab::audit {

/// A member whose confirmed world was not a trace's, by the hashes that it told. No finding: it lies, or somebody has
/// told it, or the trace's peer, something else.
struct OtherWorld {
  MemberId who = 0;
  std::size_t trace = 0;
  Tick noticed = 0;  ///< when the trace's peer found out
};

struct Report {
  std::vector<std::string> labels;     ///< of traces
  std::vector<std::string> truncated;  ///< of those of them that break off
  std::vector<std::string> with_rest;  ///< of those that something follows which is no record
  Evidence evidence;
  std::vector<Finding> findings;  ///< by member, then kind, the worst first
  std::vector<Push> pushes;       ///< by member and tick
  std::vector<OtherWorld> other_worlds;
  std::array<Measure, kKinds> closest{};  ///< by kind, in physics: what came nearest to a limit, or exceeded it by most
  std::uint64_t updates = 0;              ///< different ones, in all traces
  std::uint64_t judged = 0;               ///< by the physics of one trace or another
};

struct Options {
  /// Whether members may have pushed bodies: otherwise what looks like a push is judged like any other claim.
  bool pushes = true;
};

/// Reads the traces of one session and plays each again. Throws UserError if one is damaged or does not do again what
/// it did, or if they are of several sessions.
Report audit(const std::vector<TraceText>& traces, const Options& options);

/// By how much what was measured exceeds what is allowed: 1 is the limit.
float severity(const Finding& f);

}  // namespace padr::lab::audit
