#include "tools/monitor/options.h"

#include <CLI/CLI.hpp>

#include "common/model/user_error.h"
#include "shell/command_line.h"
#include "tools/capture/setting.h"
#include "tools/monitor/guard.h"

namespace padr::monitor {
namespace {

constexpr const char* kDescription =
    "Serves one web page for a whole session. The page shows every peer's view side by side, and live inconsistency\n"
    "and traffic. It can drive the avatars and turn the knobs of peers with --control. It also plays recordings.";

constexpr const char* kFooter =
    "HOST is a name, an IPv4 address, or an IPv6 address in brackets. The whole page is in this program and needs no\n"
    "other server. Open the address that the program prints. While no peer is there, the page lists stories to watch.\n"
    "\n"
    "A session on this machine, to look at and to play with:\n"
    "  padr-monitor &\n"
    "  padr-peer --listen 127.0.0.1:7001 --monitor 127.0.0.1:9200 --control &\n"
    "  padr-peer --join 127.0.0.1:7001 --monitor 127.0.0.1:9200 --control\n"
    "A recording by peers, or a packet capture:\n"
    "  padr-monitor --trace out/demo\n"
    "  padr-monitor --capture peer0.pcapng\n"
    "Pages on other machines too, in a network that you trust; they control the peers with the token:\n"
    "  PADR_CONTROL_TOKEN=... padr-monitor --listen 0.0.0.0:8080 --peers-listen 0.0.0.0:9200 --insecure\n"
    "\n"
    "A page may control peers if its address ends in '#token=' and the token, or, where no token is set, if it is "
    "open\n"
    "on the monitor's own machine and no proxy has passed it on. The program answers only requests to an IP address or "
    "to the names localhost, HOST and --allow-host. Only\n"
    "its own pages may connect. It also serves /metrics for Prometheus, /api/session as JSON and /api/path?peer=N as\n"
    "CSV.\n"
    "\n"
    "Messages go to standard error, the address to standard output. SIGINT, SIGTERM or SIGHUP ends the program. Exit\n"
    "code: 0 after a signal or --duration; 1 if an address cannot be used; 2 if the command line or a file that it "
    "names\n"
    "is wrong.";

struct Raw {
  std::string listen = "127.0.0.1:8080";
  std::string peers = "127.0.0.1:9200";
};

void declare(CLI::App& app, Raw& raw, Options& o) {
  app.add_option("--listen", raw.listen, "Address for browsers; port 0 means any free port")
      ->type_name("HOST:PORT")
      ->capture_default_str();
  app.add_option("--peers-listen", raw.peers, "Address for peers (UDP), their --monitor; port 0 means any free port")
      ->type_name("HOST:PORT")
      ->capture_default_str();
  app.add_option("--trace", o.traces, "Play traces of one session: files, and folders of NAME.trace")
      ->type_name("FILE|FOLDER");
  app.add_option("--capture", o.captures, "Play the agreed world, rebuilt from packet captures of one session")
      ->type_name("FILE");
  app.add_flag("--insecure", o.insecure,
               "Allow addresses that other machines can reach; senders are not authenticated");
  app.add_flag("--view-only", o.view_only, "No page may control anything");
  app.add_option("--control-token", o.token,
                 "Token with which pages may control peers, 8 to 200 characters; without one, only pages on this\n"
                 "machine may. Other users can see a command line, so better give it in the environment.\n"
                 "In a page's address & is written %26, and % is written %25")
      ->type_name("TOKEN")
      ->envname("PADR_CONTROL_TOKEN");
  app.add_option("--allow-host", o.names, "Also serve the page under this host name; may be repeated")
      ->type_name("NAME")
      ->allow_extra_args(false);
  app.add_option("--duration", o.duration, "Seconds to run; 0: until a signal")
      ->type_name("S")
      ->check(shell::between(0.0, 1.0e7, "seconds"))
      ->capture_default_str();
}

void check(const Options& o) {
  if (!o.traces.empty() && !o.captures.empty()) throw UserError("--trace and --capture do not go together; give one");
  if (!o.token.empty() && (o.token.size() < 8 || o.token.size() > 200))
    throw UserError("--control-token or PADR_CONTROL_TOKEN: " + std::to_string(o.token.size()) +
                    " characters are not allowed; give 8 to 200");
  for (const std::string& name : o.names)
    if (!is_host_name(name))
      throw UserError("--allow-host: '" + name + "' is not a host name; give it without scheme, port and path");
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv) {
  Raw raw;
  Options o;
  CLI::App app(kDescription, "padr-monitor");
  app.footer(kFooter);
  shell::add_version_flag(app, "padr-monitor");
  declare(app, raw, o);
  o.setting.declare(app, "Captures");
  capture::declare_keylogs(app, o.keylogs);
  for (CLI::Option* option : app.get_options())
    if (option->get_group() == "Captures" || option->get_name() == "--keylog")
      option->needs(app.get_option("--capture"));
  if (!shell::parse(app, argc, argv)) return std::nullopt;
  check(o);
  o.listen = shell::parse_host_port("--listen", raw.listen, 0);
  o.peers = shell::parse_host_port("--peers-listen", raw.peers, 0);
  o.names.push_back(o.listen.host);
  return o;
}

}  // namespace padr::monitor
