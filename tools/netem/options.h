#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/link/netem_spec.h"
#include "shell/host_port.h"

namespace padr::netem {

using shell::HostPort;

struct LinkOptions {
  HostPort listen;  ///< port 0: any free one
  HostPort target;  ///< port 1 to 65535
  link::NetemSpec to_target;
  link::NetemSpec to_client;
};

struct Options {
  std::vector<LinkOptions> links;  ///< at least one
  std::uint64_t seed = 1;
  double stats_interval = 1;  ///< s; 0: only at the end
  double duration = 0;        ///< s; 0: until a signal
  std::size_t max_clients = 256;
  double client_idle = 60;            ///< s without a datagram after which a client is forgotten
  std::vector<std::string> warnings;  ///< about legal but doubtful specifications
};

/// Reads the command line. Nothing if it was a request for help or version, which has then been printed.
/// Throws UserError with one line that names the flag and what is allowed.
std::optional<Options> parse_options(int argc, const char* const* argv);

}  // namespace padr::netem
