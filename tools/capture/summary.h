#pragma once

#include <string>
#include <vector>

#include "tools/capture/input.h"
#include "tools/capture/tally.h"

namespace padr::capture {

/// What goes with every result.
struct Source {
  std::vector<std::string> files;
  Contents contents;
  std::vector<std::string> troubles;  ///< why it is a part of what was to be read; empty if it is all
};

/// For people.
std::string summary_text(const Source& source, const Tally& tally);
/// The same and more as JSON. `command`: this program's own.
std::string summary_json(const Source& source, const Tally& tally, const std::vector<std::string>& command);

/// "1", or "1.130" for an incarnation that came later.
std::string life_name(const Tally& tally, const LifeKey& who);
/// "0 -> 1".
std::string link_name(const Tally& tally, const LinkKey& link);

/// Of a session, by sender and receiver.
std::vector<std::pair<LinkKey, const LinkTally*>> links_of(const Tally& tally, std::uint16_t session);

/// One-way delay of a link by the capture: how long after its tick began a datagram is in the capture.
struct DelayFigures {
  double mean_ms = 0;
  double p50_ms = 0;
  double p95_ms = 0;
  double least_ms = 0;
  double jitter_ms = 0;
};
/// Of a link's numbers from the first to the last in the capture, the share that is not in it: lost before it came
/// there.
double loss_percent(const LinkTally& link);
/// `tick0`: its capture time, us.
DelayFigures delays_of(const LinkTally& link, std::int64_t tick0);

}  // namespace padr::capture
