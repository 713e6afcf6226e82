#include "shell/host_port.h"

#include <charconv>

#include "common/model/user_error.h"

namespace padr::shell {

HostPort parse_host_port(std::string_view flag, std::string_view text, int lowest_port) {
  const auto bad = [&](std::string_view why) {
    return UserError(std::string(flag) + ": '" + std::string(text) + "': " + std::string(why) +
                     "; allowed: HOST:PORT, such as 127.0.0.1:7001, peer:7001 or [::1]:7001, PORT from " +
                     std::to_string(lowest_port) + " to 65535");
  };
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos) throw bad("no port");
  std::string_view host = text.substr(0, colon);
  const std::string_view port = text.substr(colon + 1);
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    throw bad("an IPv6 address needs brackets");
  }
  if (host.empty()) throw bad("no host");
  int number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  if (error != std::errc() || end != port.data() + port.size() || number < lowest_port || number > 65535)
    throw bad("not a port");
  return {std::string(text), std::string(host), static_cast<std::uint16_t>(number)};
}

}  // namespace padr::shell
