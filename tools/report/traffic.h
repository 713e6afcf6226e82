#pragma once

#include <map>
#include <set>
#include <vector>

#include "common/sync/packet.h"
#include "tools/report/report.h"

namespace padr::report {

/// What a peer sent, told from its datagrams alone: each update once, whoever and how often it was sent to.
class TrafficMeter {
 public:
  /// A datagram of `wire_bytes` bytes, headers included, sent at a tick.
  void sent(PeerId to, Tick tick, const sync::StatePacket& packet, std::size_t wire_bytes);

  const Traffic& total() const { return total_; }
  /// By second of the session.
  const std::vector<Traffic>& per_second() const { return per_second_; }

 private:
  void bundle(PeerId to, const sync::Bundle& b, double size, Traffic& into);

  Traffic total_;
  std::vector<Traffic> per_second_;
  std::set<std::uint32_t> counted_;                 ///< indices of bundles
  std::map<PeerId, std::set<std::uint32_t>> told_;  ///< likewise, by receiver
};

}  // namespace padr::report
