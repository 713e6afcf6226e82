#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace padr::shell {

/// A UDP address as a user writes it: HOST:PORT, where HOST is a name, an IPv4 address or an IPv6 address in brackets.
struct HostPort {
  std::string text;  ///< for messages
  std::string host;  ///< name or address, without brackets
  std::uint16_t port = 0;
};

/// Throws UserError, which names the flag, for anything else and for ports below `lowest_port`.
HostPort parse_host_port(std::string_view flag, std::string_view text, int lowest_port);

}  // namespace padr::shell
