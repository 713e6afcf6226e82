#pragma once

#include <string>

#include "peer/egress.h"
#include "peer/options.h"
#include "peer/player.h"
#include "peer/telemetry.h"
#include "shell/udp_socket.h"

namespace padr::peer {

/// What a run's summary is made from.
struct Report {
  const Options& options;
  const Player& player;
  const Egress& egress;
  const shell::UdpSocket& socket;
  const Telemetry* telemetry;  ///< null: there is no monitor
  Endpoint local;
  int exit_code;
  std::string reason;  ///< why it ended, one line
};

/// The summary as JSON.
std::string summary(const Report& report);

}  // namespace padr::peer
