#include "shell/stop_signals.h"

#include <csignal>

namespace padr::shell {

void add_stop_signals(boost::asio::signal_set& signals) {
  std::signal(SIGPIPE, SIG_IGN);
  signals.add(SIGINT);
  signals.add(SIGTERM);
  struct sigaction hangup {};
  if (sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN) signals.add(SIGHUP);
}

std::string_view name_of_signal(int signal) {
  switch (signal) {
    case SIGINT:
      return "SIGINT";
    case SIGHUP:
      return "SIGHUP";
    default:
      return "SIGTERM";
  }
}

}  // namespace padr::shell
