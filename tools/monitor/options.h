#pragma once

#include <optional>
#include <string>
#include <vector>

#include "shell/host_port.h"
#include "tools/capture/setting.h"

namespace padr::monitor {

struct Options {
  shell::HostPort listen;             ///< HTTP; port 0: any free one
  shell::HostPort peers;              ///< UDP; likewise
  std::vector<std::string> traces;    ///< files and folders; empty: live
  std::vector<std::string> captures;  ///< likewise
  std::vector<std::string> keylogs;   ///< of encrypted ones
  std::vector<std::string> names;     ///< host names that are served besides the usual
  capture::SettingFlags setting;      ///< what a capture does not tell
  bool insecure = false;
  bool view_only = false;
  std::string token;    ///< empty: only pages on this machine can control
  double duration = 0;  ///< s; 0: until a signal
};

/// Reads the command line. Nothing if it was a request for help or version, which has then been printed.
/// Throws UserError with one line that names the flag and what is allowed.
std::optional<Options> parse_options(int argc, const char* const* argv);

}  // namespace padr::monitor
