#include "tools/netem/options.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <set>
#include <string_view>
#include <utility>

#include "common/model/user_error.h"
#include "shell/command_line.h"
#include "shell/netem_flags.h"

namespace padr::netem {

namespace {

constexpr const char* kDescription =
    "UDP relay that impairs datagrams as tc-netem does, without root and with a seed.\n"
    "It listens on each LISTEN and relays datagrams to TARGET. It relays each reply back to its client.\n"
    "Each client and each direction has its own queue and random stream. Two peers that come in through the relay do\n"
    "not reach each other: in a session of three or more use padr-peer --netem.";

constexpr const char* kFooter =
    "LISTEN and TARGET are HOST:PORT, HOST a name, an IPv4 address or an IPv6 address in brackets.\n";

constexpr const char* kFooterEnd =
    "\n"
    "With jitter datagrams overtake each other, unless there is a rate. corrupt flips one bit of the payload; the\n"
    "relay sends the datagram with a valid checksum, so the receiver gets it.\n"
    "\n"
    "Example: 100 ms +- 20 ms and bursts of losses towards a peer on port 7001, 50 ms back, for one minute:\n"
    "  padr-netem --link 127.0.0.1:6001=127.0.0.1:7001 --netem 'delay 100ms 20ms loss gemodel 1% 30%' \\\n"
    "             --netem-back 'delay 50ms' --seed 7 --duration 60\n"
    "\n"
    "Statistics go to standard output, messages to standard error. Exit code: 0 after --duration, SIGINT, SIGTERM\n"
    "or SIGHUP, 1 if a port cannot be used, 2 if the command line is wrong or a name is unknown.";

/// What CLI11 fills in, before anything is checked.
struct RawOptions {
  std::vector<std::string> links, netem_for, netem_back_for;
  std::string netem, netem_back;
};

std::pair<std::string, std::string> split_at_equals(const std::string& text, std::string_view flag,
                                                    std::string_view form) {
  const auto equals = text.find('=');
  if (equals == std::string::npos) {
    throw UserError(std::string(flag) + ": \"" + text + "\" has no \"=\"; allowed: " + std::string(form));
  }
  return {text.substr(0, equals), text.substr(equals + 1)};
}

void override_specs(const std::vector<std::string>& overrides, const std::string& flag,
                    link::NetemSpec LinkOptions::*spec, Options& options) {
  std::set<std::string> given;
  for (const std::string& text : overrides) {
    const auto [listen, words] = split_at_equals(text, flag, "LISTEN=SPEC");
    if (!given.insert(listen).second) throw UserError(flag + ": given twice for " + listen + "; give it once");
    bool found = false;
    for (LinkOptions& l : options.links) {
      if (l.listen.text != listen) continue;
      l.*spec = shell::parse_netem_flag(flag + " " + listen, words, &options.warnings);
      found = true;
    }
    if (!found) throw UserError(flag + ": no --link listens on \"" + listen + "\"; write LISTEN as in --link");
  }
}

void declare(CLI::App& app, RawOptions& raw, Options& options) {
  app.footer(kFooter + shell::netem_help() + kFooterEnd);
  shell::add_version_flag(app, "padr-netem");
  app.add_option("--link", raw.links, "Relay from LISTEN to TARGET; required, may be repeated")
      ->type_name("LISTEN=TARGET")
      ->allow_extra_args(false);
  app.add_option("--netem", raw.netem, "Impairment on the way to TARGET; default: none")->type_name("SPEC");
  app.add_option("--netem-back", raw.netem_back, "Impairment on the way back; default: none")->type_name("SPEC");
  app.add_option("--netem-for", raw.netem_for, "Impairment of one link, in place of --netem; may be repeated")
      ->type_name("LISTEN=SPEC")
      ->allow_extra_args(false);
  app.add_option("--netem-back-for", raw.netem_back_for,
                 "Impairment of one link, in place of --netem-back; may be repeated")
      ->type_name("LISTEN=SPEC")
      ->allow_extra_args(false);
  app.add_option("--seed", options.seed, "Random seed; the same seed impairs the same arrivals alike")
      ->check(shell::whole_number())
      ->capture_default_str();
  app.add_option("--stats-interval", options.stats_interval, "Seconds between statistics; 0: only at the end")
      ->check(shell::range(0.0, 86400.0))
      ->capture_default_str();
  app.add_option("--duration", options.duration, "Seconds to run; 0: until SIGINT, SIGTERM or SIGHUP")
      ->check(shell::range(0.0, 1e9))
      ->capture_default_str();
  app.add_option("--max-clients", options.max_clients, "Clients of one link at a time; further ones are ignored")
      ->check(shell::range(1, 10000))
      ->capture_default_str();
  app.add_option("--client-idle", options.client_idle, "Seconds of silence after which a client is forgotten")
      ->check(shell::range(0.1, 86400.0))
      ->capture_default_str();
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv) {
  RawOptions raw;
  Options options;
  CLI::App app(kDescription, "padr-netem");
  declare(app, raw, options);
  if (!shell::parse(app, argc, argv)) return std::nullopt;
  if (raw.links.empty()) throw UserError("--link: at least one LISTEN=TARGET is needed (see --help)");
  const link::NetemSpec to_target = shell::parse_netem_flag("--netem", raw.netem, &options.warnings);
  const link::NetemSpec to_client = shell::parse_netem_flag("--netem-back", raw.netem_back, &options.warnings);
  for (const std::string& text : raw.links) {
    const auto [listen, target] = split_at_equals(text, "--link", "LISTEN=TARGET");
    if (listen == target) throw UserError("--link: \"" + text + "\" would relay to itself");
    for (const LinkOptions& l : options.links)
      if (l.listen.text == listen && l.listen.port != 0)
        throw UserError("--link: two of them listen on \"" + listen + "\"");
    options.links.push_back({shell::parse_host_port("--link LISTEN", listen, 0),
                             shell::parse_host_port("--link TARGET", target, 1), to_target, to_client});
  }
  override_specs(raw.netem_for, "--netem-for", &LinkOptions::to_target, options);
  override_specs(raw.netem_back_for, "--netem-back-for", &LinkOptions::to_client, options);
  return options;
}

}  // namespace padr::netem
