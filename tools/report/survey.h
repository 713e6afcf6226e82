#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/report/report.h"

namespace padr::report {

struct TraceBytes {
  std::string label;  ///< the file, for messages
  std::vector<std::byte> bytes;
};

/// What has to be known of a trace before it is measured beside others.
struct Survey {
  trace::Header header;
  std::string name;          ///< "3", or "3.2" for the second in the slot of which there is a trace
  Tick first_step = -1;      ///< -1: none
  Tick came = -1;            ///< first tick at which its avatar was a part of the session; -1: never
  Tick last_tick = -1;       ///< of the trace
  Tick confirmed_from = -1;  ///< -1: nothing
  bool superseded = false;   ///< the peer went on in another incarnation

  /// From when it watched on: others send to it before it knows that it is in.
  bool covers(Tick t) const { return came >= 0 && t >= first_step && t <= last_tick; }
};

/// Reads a trace from end to end. Throws UserError if it is damaged.
Survey survey(const TraceBytes& trace);

/// The survey of that slot and incarnation that is there at this tick; nothing if there is no trace of one. The two
/// sides of a partition may number newcomers alike: the last one counts.
std::optional<std::size_t> life_at(const std::vector<Survey>& all, PeerId slot, std::uint32_t incarnation, Tick t);

/// Throws UserError if they are not of one session, each of another incarnation.
void check_together(const std::vector<Survey>& all, const std::vector<TraceBytes>& traces);

/// The order to measure traces in: by slot, then by incarnation.
std::vector<std::size_t> in_order(const std::vector<Survey>& all);

/// Names those that are ordered so.
void give_names(std::vector<Survey>& ordered);

}  // namespace padr::report
