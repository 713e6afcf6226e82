#include "tools/monitor/options.h"

#include <CLI/CLI.hpp>

#include "common/model/user_error.h"
#include "tools/capture/setting.h"
#include "tools/support/command_line.h"

namespace padr::monitor {
namespace {

constexpr const char* kDescription =
    "One web page for a whole session: every peer's view side by side, inconsistency and traffic as they happen, and,\n"
    "where peers allow it, their avatars to drive and their knobs to turn. Also plays recordings.";

constexpr const char* kFooter =
    "HOST is a name, an IPv4 address, or an IPv6 address in brackets. The page needs no other server: all of it is in\n"
    "this program. Open the address that it prints. While no peer is there, the page lists stories to watch.\n"
    "\n"
    "A session on this machine, to look at and to play with:\n"
    "  padr-monitor &\n"
    "  padr-peer --listen 127.0.0.1:7001 --monitor 127.0.0.1:9200 --control &\n"
    "  padr-peer --join 127.0.0.1:7001 --monitor 127.0.0.1:9200 --control\n"
    "What peers recorded, or what went over the wire:\n"
    "  padr-monitor --trace out/demo\n"
    "  padr-monitor --capture peer0.pcapng\n"
    "From other machines too, in a network that you trust; pages control the peers with the token:\n"
    "  PADR_CONTROL_TOKEN=... padr-monitor --listen 0.0.0.0:8080 --peers-listen 0.0.0.0:9200 --insecure\n"
    "\n"
    "A page may control if it is open on the monitor's own machine, or has the token, behind '#token=' in its "
    "address.\n"
    "Only addresses and the names localhost, HOST and --allow-host are served, and only pages that come from here may\n"
    "connect. Besides the page: /metrics for Prometheus, /api/session as JSON, /api/path?peer=N as CSV.\n"
    "\n"
    "Messages go to standard error, the address to standard output. SIGINT or SIGTERM ends it. Exit code: 0 when it\n"
    "was ended; 1 if an address cannot be used; 2 if the command line or a file it names is wrong.";

struct Raw {
  std::string listen = "127.0.0.1:8080";
  std::string peers = "127.0.0.1:9200";
};

void declare(CLI::App& app, Raw& raw, Options& o) {
  app.add_option("--listen", raw.listen, "Where pages come to; port 0 takes any")
      ->type_name("HOST:PORT")
      ->capture_default_str();
  app.add_option("--peers-listen", raw.peers, "Where peers send to (UDP), their --monitor; port 0 takes any")
      ->type_name("HOST:PORT")
      ->capture_default_str();
  app.add_option("--trace", o.traces, "Play traces of one session: files, and folders of NAME.trace")
      ->type_name("FILE|FOLDER");
  app.add_option("--capture", o.captures, "Play the agreed world, rebuilt from packet captures of one session")
      ->type_name("FILE");
  app.add_flag("--insecure", o.insecure, "Allow addresses that other machines can reach: nothing proves who sends");
  app.add_flag("--view-only", o.view_only, "No page may control anything");
  app.add_option("--control-token", o.token,
                 "Pages on other machines may control if they have it; 8 to 200 characters; better given in the\n"
                 "environment, where other users do not see it")
      ->type_name("TOKEN")
      ->envname("PADR_CONTROL_TOKEN");
  app.add_option("--allow-host", o.names, "Serve pages under this name, too; may be repeated")
      ->type_name("NAME")
      ->allow_extra_args(false);
  app.add_option("--duration", o.duration, "Seconds to run; 0: until a signal")
      ->type_name("S")
      ->check(support::between(0.0, 1.0e7, "seconds"))
      ->capture_default_str();
}

void check(const Options& o) {
  if (!o.traces.empty() && !o.captures.empty()) throw UserError("--trace and --capture do not go together; give one");
  if (!o.token.empty() && (o.token.size() < 8 || o.token.size() > 200))
    throw UserError("--control-token: " + std::to_string(o.token.size()) +
                    " characters are not allowed; give 8 to 200");
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv) {
  Raw raw;
  Options o;
  CLI::App app(kDescription, "padr-monitor");
  app.footer(kFooter);
  support::add_version_flag(app, "padr-monitor");
  declare(app, raw, o);
  o.setting.declare(app, "Captures");
  capture::declare_keylogs(app, o.keylogs);
  if (!support::parse(app, argc, argv)) return std::nullopt;
  check(o);
  o.listen = support::parse_host_port("--listen", raw.listen, 0);
  o.peers = support::parse_host_port("--peers-listen", raw.peers, 0);
  o.names.push_back(o.listen.host);
  return o;
}

}  // namespace padr::monitor
