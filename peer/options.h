#pragma once

#include <spdlog/common.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/crowd/regions.h"
#include "common/link/netem_spec.h"
#include "common/model/ids.h"
#include "common/model/technique.h"
#include "common/monitor/telemetry.h"
#include "common/wire/sealed.h"
#include "shell/host_port.h"
#include "shell/scenario_flags.h"

namespace padr::peer {

/// --netem-to: another impairment towards one destination, named by peer number or by address.
struct NetemOverride {
  std::optional<PeerId> peer;
  std::optional<shell::HostPort> address;  ///< exactly one of the two is given
  link::NetemSpec spec;
};

/// --monitor and what goes with it.
struct MonitorOptions {
  shell::HostPort where;
  int rate = 20;  ///< frames a second
  monitor::Detail detail = monitor::Detail::kAll;
  bool control = false;  ///< it may give orders
};

/// --crowd and what goes with it.
struct CrowdOptions {
  crowd::Plane plane;
  Vec2 start;         ///< m, where the avatar is first
  double stroll = 0;  ///< m, side of the square around `start` that made-up motion stays in
  Scene ground;       ///< that square, for input
};

struct Options {
  std::optional<shell::HostPort> listen;  ///< absent: any port on the loopback address of the family needed
  std::vector<shell::HostPort> join;      ///< members to ask, in turn; none: found a session
  int wait_peers = 2;                     ///< founder: players that play waits for
  int slots = 2;                          ///< founder: slots, its own included
  bool map_port = false;
  bool insecure = false;
  std::optional<wire::Key> key;                 ///< of the session; absent: nothing is sealed
  wire::SealMode seal = wire::SealMode::kNone;  ///< kNone without a key, and only then
  std::string keylog;                           ///< file; empty: none
  double join_timeout = 30;                     ///< s, until the session must have started; 0: no limit
  bool spectates = false;                       ///< it has no avatar
  bool meeting_point = false;                   ///< likewise, and it passes on as much as others ask it to

  shell::LoadedScenario scenario;     ///< of a session
  std::optional<CrowdOptions> crowd;  ///< it plays in a crowd, in place of a session
  Technique technique;
  std::string input = "wander";
  double duration = 0;  ///< s of play; 0: until a signal
  double linger = 3;    ///< s after the end of play, at most

  link::NetemSpec netem;
  std::string netem_text;  ///< of all links, and of those of --netem-to
  std::vector<NetemOverride> netem_to;
  std::uint64_t netem_seed = 1;

  std::string trace;   ///< file; empty: none
  std::string pcap;    ///< file; empty: none
  std::string json;    ///< file, or - for standard output; empty: none
  std::string health;  ///< file; empty: none
  std::optional<MonitorOptions> monitor;
  spdlog::level::level_enum log_level = spdlog::level::info;
  std::map<std::string, spdlog::level::level_enum> log_levels;  ///< by subsystem
  double status_interval = 1;                                   ///< s; 0: no status line

  std::vector<std::string> command;
  std::vector<std::string> warnings;  ///< about legal but doubtful values
};

/// Reads the command line and the files it names, all but the trace. Nothing if it was a request for help or version,
/// which has then been printed. Throws UserError with one line.
std::optional<Options> parse_options(int argc, const char* const* argv);

}  // namespace padr::peer
