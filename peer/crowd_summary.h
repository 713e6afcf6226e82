#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/crowd/crowd_peer.h"
#include "peer/lateness.h"
#include "peer/options.h"
#include "shell/udp_socket.h"

namespace padr::peer {

/// What a peer of a crowd has come to know, for its summary.
struct CrowdRecord {
  struct Place {
    crowd::Region region;
    PeerId slot = kNoPeer;
    std::uint32_t incarnation = 0;
    std::vector<Endpoint> others;  ///< members
    Tick confirmed = -1;
    std::uint64_t checks = 0;
    std::uint64_t mismatches = 0;
  };
  /// Of a region, at whole seconds, the last kCheckpoints; where two incarnations have been at the same tick, of the
  /// later.
  std::map<crowd::Region, std::map<Tick, std::uint64_t>> checkpoints;
  Tick first_tick = -1;       ///< played; -1: it never came in
  Micros joined_at = -1;      ///< us
  Tick last_tick = -1;        ///< before it said goodbye
  crowd::Region home;         ///< then
  Vec2 position;              ///< then, m
  std::vector<Place> places;  ///< then
  std::uint64_t late = 0;     ///< ticks begun more than a tick after their time
  Lateness lateness;

  void confirm(crowd::Region r, Tick tick, std::uint64_t hash);
  /// How things stand now.
  void look(const crowd::CrowdPeer& peer);

  static constexpr std::size_t kCheckpoints = 600;
  static constexpr std::size_t kRegions = 256;  ///< of which checkpoints are kept
};

/// What the summary of --json is made from.
struct CrowdReport {
  const Options& options;
  const CrowdRecord& record;
  const crowd::CrowdPeer& peer;
  const shell::SocketStats& socket;
  Endpoint local;
  int exit_code;
  std::string reason;  ///< why it ended, one line
};

/// The summary as JSON.
std::string summary(const CrowdReport& report);

}  // namespace padr::peer
