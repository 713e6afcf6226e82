#include "peer/options.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "common/model/rng.h"
#include "common/model/user_error.h"
#include "peer/log.h"
#include "peer/session_key.h"
#include "shell/command_line.h"
#include "shell/netem_flags.h"
#include "shell/technique_flags.h"
#include "shell/unpredictable.h"

namespace padr::peer {
namespace {

using shell::parse_host_port;

constexpr const char* kDescription =
    "One peer of a session of shared physics over UDP. It runs its own deterministic world with one avatar. It takes\n"
    "authority over the bodies that the avatar touches, and sends an update when the guess of the others is too wrong.";

constexpr const char* kFooter =
    "HOST is a name, an IPv4 address, or an IPv6 address in brackets. Peers of a session must have the same scenario,\n"
    "seed (where the scene depends on it) and authority rule (avatar-only or not); each peer may choose all other\n"
    "knobs for itself.\n"
    "\n"
    "A session needs no particular peer: any peer may join and leave while it runs, and the founder may leave too. A\n"
    "silent peer is declared gone after some seconds. A peer that was declared gone or disconnected joins again by\n"
    "itself, and takes over the session's world.\n"
    "\n"
    "Two peers on this machine, with a bad network between them, for 20 s:\n"
    "  padr-peer --listen 127.0.0.1:7001 --wait-peers 2 --netem 'delay 100ms 50ms loss 10%' --duration 20\n"
    "  padr-peer --join 127.0.0.1:7001 --netem 'delay 100ms 50ms loss 10%' --duration 20\n"
    "An avatar driven by a recorded path, the paper's technique, a trace for padr-report, a summary for a program:\n"
    "  padr-peer --join 127.0.0.1:7001 --technique adaptive --threshold 0.8:0.3 --input path:mouse.csv,loop \\\n"
    "            --trace peer1.trace --json peer1.json\n"
    "A lossy link to peer 2 alone, and one to an address:\n"
    "  padr-peer --join '[::1]:7001' --netem-to '2=loss 20%' --netem-to '[::1]:7003=delay 300ms'\n"
    "Two peers of a crowd (any number can join):\n"
    "  padr-peer --crowd --listen 127.0.0.1:7001 --duration 20\n"
    "  padr-peer --crowd --join 127.0.0.1:7001 --start 40,12 --duration 20\n"
    "Between machines, with a key that only the peers have:\n"
    "  padr-peer keygen session.key\n"
    "  padr-peer --listen 0.0.0.0:7001 --key-file session.key --wait-peers 3\n"
    "  padr-peer --listen 0.0.0.0:0 --join HOST:7001 --key-file session.key\n"
    "Whether two machines compute the same physics; they do if both print the same fingerprint:\n"
    "  padr-peer fingerprint\n"
    "\n";

constexpr const char* kFooterEnd =
    "\n"
    "\n"
    "Messages and the status line go to standard error. SIGINT, SIGTERM or SIGHUP leaves the session properly;\n"
    "a second signal ends the program at once. Exit code: 0 on success; 1 if the peer could not join, the session did\n"
    "not start, confirmed worlds differed, or a system call failed; 2 if the command line or a file that it names is "
    "wrong.";

/// What CLI11 fills in, before anything is checked.
struct Raw {
  std::string listen, json, trace, log_level = "info", log, key_file, seal;
  std::string monitor, monitor_detail = "all";
  int monitor_rate = 20;
  bool control = false;
  std::vector<std::string> join, netem_to;
  std::optional<int> wait_peers, slots;
  bool crowd = false;
  std::string start;
  std::optional<double> stroll, region_side;
  shell::ScenarioFlags scenario;
  shell::TechniqueFlags technique;
  shell::NetemFlags netem;
};

void declare_session(CLI::App& app, Raw& raw, Options& o) {
  const std::string group = "Session";
  app.add_option("--listen", raw.listen,
                 "Own address; port 0 means any free port; default: any free port of the loopback address")
      ->type_name("HOST:PORT")
      ->group(group);
  app.add_option(
         "--join", raw.join,
         "Address of any member of the session to join; without --join the peer founds a session. May be given\n"
         "several times: where nobody answers, the next one is asked")
      ->type_name("HOST:PORT")
      ->allow_extra_args(false)
      ->group(group);
  app.add_option("--wait-peers", raw.wait_peers,
                 "Founder: start when this number of players is there, the founder included if it plays [2]")
      ->type_name("N")
      ->group(group);
  app.add_option("--slots", raw.slots,
                 "Founder: avatar slots, so at most this number of peers at once; default: the number of the\n"
                 "scenario's spawn points, but at most 32 (or --wait-peers, if that is more)")
      ->type_name("N")
      ->group(group);
  app.add_option("--join-timeout", o.join_timeout,
                 "Give up if the session has not started, or has not admitted this peer, after S seconds; 0: never")
      ->type_name("S")
      ->check(shell::between(0.0, 86400.0, "seconds"))
      ->capture_default_str()
      ->group(group);
  app.add_flag(
         "--map-port", o.map_port,
         "Ask the router, by NAT-PMP or UPnP, to forward the port of --listen, so that others can join this peer\n"
         "from outside; the log says where. Takes up to 4 s")
      ->group(group);
  app.add_flag("--spectate", o.spectates,
               "Only watch: a member without an avatar. It takes a slot, and --wait-peers does not count it")
      ->group(group);
  app.add_flag(
         "--meeting-point", o.meeting_point,
         "As --spectate, for a machine that all peers can reach: it introduces peers that cannot reach each other,\n"
         "carries up to 1 MB/s for them, and waits for the first ones for ever")
      ->group(group);
  app.add_flag(
         "--insecure", o.insecure,
         "Without a key: allow addresses that other machines can reach; senders are then not authenticated. With\n"
         "--control, with a key or without: obey a monitor on another machine, too")
      ->group(group);
}

constexpr std::array kNotInACrowd{"--scenario",       "--wait-peers", "--slots",    "--trace", "--health", "--monitor",
                                  "--monitor-detail", "--control",    "--key-file", "--seal",  "--keylog"};

void declare_crowd(CLI::App& app, Raw& raw) {
  const std::string group = "Crowd";
  app.add_flag("--crowd", raw.crowd,
               "Play in a crowd, on a plane without end, not in a session. --join names any peer of the crowd;\n"
               "without --join this is its first peer. --seed sets the plane; all peers of a crowd need the same.\n"
               "These are not for crowds: " +
                   fmt::format("{}", fmt::join(kNotInACrowd, ", ")))
      ->group(group);
  app.add_option("--start", raw.start, "Where the avatar starts, m [a random place in the region 0,0]")
      ->type_name("X,Y")
      ->group(group);
  app.add_option("--stroll", raw.stroll, "--input wander stays in a square around the start; its side, m [24]")
      ->check(shell::between(4.0, 10000.0, "metres"))
      ->type_name("M")
      ->group(group);
  app.add_option("--region-side", raw.region_side,
                 "Side of the plane's regions, m; all peers of a crowd need the same [24]")
      ->check(shell::between(16.0, 200.0, "metres"))
      ->type_name("M")
      ->group(group);
}

void declare_key(CLI::App& app, Raw& raw, Options& o) {
  const std::string group = "Key";
  app.add_option("--key-file", raw.key_file,
                 "File with the session's key, made by padr-peer keygen; all peers need the same key; default: the\n"
                 "key in the environment variable PADR_KEY; without both the session has no key")
      ->type_name("FILE")
      ->group(group);
  app.add_option("--seal", raw.seal,
                 "With a key: auth or encrypt. Both prove who sends; auth leaves datagrams readable, encrypt hides\n"
                 "what is in them. Each peer chooses for what it sends [auth]")
      ->type_name("MODE")
      ->group(group);
  app.add_option("--keylog", o.keylog,
                 "With a key: write what padr-capture needs to check and decrypt this peer's datagrams; only you may\n"
                 "read the file")
      ->type_name("FILE")
      ->group(group);
}

void declare_play(CLI::App& app, Options& o) {
  const std::string group = "Play";
  app.add_option("--input", o.input, shell::kInputHelp)->type_name("INPUT")->capture_default_str()->group(group);
  app.add_option("--duration", o.duration, "Seconds to play after joining; 0: until a signal")
      ->type_name("S")
      ->check(shell::between(0.0, 1.0e7, "seconds"))
      ->capture_default_str()
      ->group(group);
  app.add_option(
         "--linger", o.linger,
         "After --duration stay for S seconds while others play on, and pass them what they lack of this peer's\n"
         "updates; after Ctrl-C only until they have it, but not longer")
      ->type_name("S")
      ->check(shell::between(0.0, 600.0, "seconds"))
      ->capture_default_str()
      ->group(group);
}

void declare_output(CLI::App& app, Raw& raw, Options& o) {
  const std::string group = "Output";
  app.add_option("--trace", raw.trace,
                 "Record everything, for padr-report and padr-lab; a peer that was declared gone and joins\n"
                 "again continues in NAME.2.trace, and so on")
      ->type_name("FILE")
      ->group(group);
  app.add_option("--pcap", o.pcap,
                 "Write every datagram that the peer sends (after --netem) and receives to a packet capture\n"
                 "(pcapng), for Wireshark and padr-capture")
      ->type_name("FILE")
      ->group(group);
  app.add_option("--json", raw.json, "Write a summary at the end; - is standard output")
      ->type_name("FILE")
      ->group(group);
  app.add_option("--health", o.health,
                 "Write a JSON file once a second, and remove it at the end. It says healthy while the peer plays\n"
                 "and its confirmed world has advanced in the last 10 s. A killed peer leaves it: look at its age, too")
      ->type_name("FILE")
      ->group(group);
  app.add_option("--status-interval", o.status_interval, "Seconds between status lines; 0: none")
      ->type_name("S")
      ->check(shell::between(0.0, 3600.0, "seconds"))
      ->capture_default_str()
      ->group(group);
  app.add_option("--log-level", raw.log_level, "trace, debug, info, warning, error or off")
      ->type_name("LEVEL")
      ->capture_default_str()
      ->group(group);
  app.add_option("--log", raw.log,
                 "Levels of single subsystems, such as net=debug,session=info; subsystems: " + subsystem_names())
      ->type_name("NAME=LEVEL,...")
      ->group(group);
}

void declare_monitor(CLI::App& app, Raw& raw) {
  const std::string group = "Monitor";
  CLI::Option* monitor =
      app.add_option("--monitor", raw.monitor,
                     "Send telemetry to a padr-monitor at this address, by UDP; the peer plays on if there is none")
          ->type_name("HOST:PORT")
          ->group(group);
  app.add_option("--monitor-rate", raw.monitor_rate, "Views of the world sent to the monitor in a second")
      ->type_name("HZ")
      ->check(shell::between(1, kTicksPerSecond, "a second"))
      ->capture_default_str()
      ->needs(monitor)
      ->group(group);
  app.add_option("--monitor-detail", raw.monitor_detail,
                 "Views sent to the monitor: shown (what the user sees), live (also the simulated state, to measure\n"
                 "inconsistency), or all (also the predicted and the confirmed world)")
      ->type_name("NAME")
      ->capture_default_str()
      ->group(group);
  app.add_flag("--control", raw.control,
               "Let the monitor drive the avatar, turn knobs, impair and cut links, push bodies and pause the peer.\n"
               "The monitor must be on this machine, unless --insecure is given")
      ->group(group);
}

void take_monitor(const Raw& raw, Options& o) {
  constexpr std::array<std::pair<std::string_view, monitor::Detail>, 3> kDetails{
      {{"shown", monitor::Detail::kShown}, {"live", monitor::Detail::kLive}, {"all", monitor::Detail::kAll}}};
  const auto* const found =
      std::find_if(kDetails.begin(), kDetails.end(), [&](const auto& d) { return d.first == raw.monitor_detail; });
  if (found == kDetails.end())
    throw UserError("--monitor-detail: '" + raw.monitor_detail + "' is not allowed; give one of shown, live, all");
  if (raw.monitor.empty()) {
    if (raw.control) throw UserError("--control: there is no monitor to obey; give --monitor, too");
    return;
  }
  o.monitor =
      MonitorOptions{parse_host_port("--monitor", raw.monitor, 1), raw.monitor_rate, found->second, raw.control};
}

spdlog::level::level_enum level_of(std::string_view flag, std::string_view text) {
  constexpr const char* kAllowed = "trace, debug, info, warning, error or off";
  const auto level = text == "warning" ? spdlog::level::warn : spdlog::level::from_str(std::string(text));
  // from_str takes what it does not know for off.
  if ((level == spdlog::level::off && text != "off") || level == spdlog::level::critical)
    throw UserError(std::string(flag) + ": '" + std::string(text) + "' is not a level; give " + kAllowed);
  return level;
}

void take_log_levels(const Raw& raw, Options& o) {
  o.log_level = level_of("--log-level", raw.log_level);
  std::string_view rest = raw.log;
  while (!rest.empty()) {
    const std::string_view item = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), item.size() + 1));
    const auto equals = item.find('=');
    const std::string name(item.substr(0, equals));
    if (equals == std::string_view::npos || !is_subsystem(name))
      throw UserError("--log: '" + std::string(item) + "' is not NAME=LEVEL with NAME one of " + subsystem_names());
    o.log_levels[name] = level_of("--log", item.substr(equals + 1));
  }
}

void take_addresses(const Raw& raw, Options& o) {
  if (o.map_port && raw.listen.empty())
    throw UserError("--map-port: without --listen nobody else reaches this peer; give --listen 0.0.0.0:PORT, too");
  if (!raw.listen.empty()) o.listen = parse_host_port("--listen", raw.listen, 0);
  for (const std::string& member : raw.join) o.join.push_back(parse_host_port("--join", member, 1));
}

void take_key(const Raw& raw, Options& o) {
  o.key = session_key(raw.key_file, o.warnings);
  const std::string mode = raw.seal.empty() ? "auth" : raw.seal;
  if (mode != "auth" && mode != "encrypt")
    throw UserError("--seal: '" + mode + "' is not a mode; give auth or encrypt");
  if (o.key) {
    o.seal = mode == "auth" ? wire::SealMode::kAuth : wire::SealMode::kEncrypt;
    if (o.insecure && !raw.control)
      o.warnings.push_back("--insecure has no meaning in a session with a key and is ignored");
    return;
  }
  for (const auto& [flag, value] : {std::pair{"--seal", raw.seal}, std::pair{"--keylog", o.keylog}})
    if (!value.empty()) throw UserError(std::string(flag) + ": there is no key; give --key-file or PADR_KEY, too");
}

void take_sizes(const Raw& raw, Options& o) {
  if (!o.join.empty()) {
    for (const auto& [flag, value] : {std::pair{"--wait-peers", raw.wait_peers}, std::pair{"--slots", raw.slots}})
      if (value) o.warnings.push_back(std::string(flag) + " is only for the founder and is ignored with --join");
    return;
  }
  const int most = std::min(kMaxPeers, static_cast<int>(o.scenario.scene.avatar.spawns.size()));
  const auto check = [&o](const char* flag, int value, int least, int at_most) {
    if (value >= least && value <= at_most) return value;
    throw UserError(std::string(flag) + ": " + std::to_string(value) + " is not allowed; give " +
                    std::to_string(least) + " to " + std::to_string(at_most) + ", by " +
                    (least > 1 ? "--wait-peers and " : "") + "the avatar slots of scenario '" + o.scenario.scene.name +
                    "'");
  };
  const int watches = o.spectates ? 1 : 0;
  o.wait_peers = check("--wait-peers", raw.wait_peers.value_or(2), 1, most - watches);
  const int least = o.wait_peers + watches;
  o.slots = check("--slots", raw.slots.value_or(std::max(least, std::min(most, shell::kUsualSlots))), least, most);
}

void take_spectator(const CLI::App& app, Options& o) {
  const char* flag = o.meeting_point ? "--meeting-point" : "--spectate";
  if (!o.spectates && !o.meeting_point) return;
  for (const char* other : {"--input", "--crowd"})
    if (app.count(other) > 0)
      throw UserError(std::string(flag) + ": cannot be used with " + other + "; leave one of them out");
  if (o.meeting_point && !o.key)
    o.warnings.push_back("--meeting-point: without a key members do not carry for one another (see docs/links.md)");
  if (o.meeting_point && app.count("--join-timeout") == 0) o.join_timeout = 0;
  o.spectates = true;
}

NetemOverride parse_override(const std::string& text, std::vector<std::string>* warnings) {
  const auto equals = text.find('=');
  if (equals == std::string::npos)
    throw UserError("--netem-to: '" + text + "' has no '='; give PEER=SPEC or HOST:PORT=SPEC");
  const std::string where = text.substr(0, equals);
  NetemOverride o;
  o.spec = shell::parse_netem_flag("--netem-to " + where, text.substr(equals + 1), warnings);
  int number = -1;
  const auto [end, error] = std::from_chars(where.data(), where.data() + where.size(), number);
  if (error == std::errc() && end == where.data() + where.size()) {
    if (number < 0 || number >= kMaxPeers)
      throw UserError("--netem-to: peer " + where + " is not allowed; give 0 to " + std::to_string(kMaxPeers - 1));
    o.peer = static_cast<PeerId>(number);
  } else {
    o.address = parse_host_port("--netem-to", where, 1);
  }
  return o;
}

/// A plane with a fence, for those who drive an avatar on it.
Scene ground_of(const crowd::Plane& plane, Vec2 start, double stroll) {
  Scene ground = crowd::scene_of(plane, crowd::region_at(plane, start));
  const auto half = static_cast<float>(stroll / 2);
  ground.lower = start - Vec2{half, half};
  ground.upper = start + Vec2{half, half};
  ground.avatar.spawns = {start};
  return ground;
}

/// Before all else: other messages would say to give what a crowd has not.
void check_crowd_flags(const CLI::App& app, const Raw& raw) {
  if (!raw.crowd) {
    for (const char* flag : {"--start", "--stroll", "--region-side"})
      if (app.count(flag) > 0) throw UserError(std::string(flag) + ": is for a crowd; give --crowd, too");
    return;
  }
  for (const char* flag : kNotInACrowd)
    if (app.count(flag) > 0)
      throw UserError(std::string(flag) + ": cannot be used in a crowd; leave it or --crowd out");
}

Vec2 start_of(const std::string& text, const crowd::Plane& plane) {
  std::array<double, 2> place{};
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (std::size_t i = 0; i < place.size(); ++i) {
    const auto [next, error] = std::from_chars(at, end, place[i]);
    const bool ends_well = i == 0 ? next != end && *next == ',' : next == end;
    if (error != std::errc() || !ends_well || !std::isfinite(place[i]))
      throw UserError("--start: '" + text + "' is not allowed; give X,Y in metres");
    at = next + 1;
  }
  const double farthest = static_cast<double>(plane.side) * crowd::kMostRegion / 2;
  for (const double v : place)
    if (std::abs(v) > farthest)
      throw UserError("--start: the plane has no regions so far out; give less than " +
                      std::to_string(std::llround(farthest)) + " metres in each direction");
  return {static_cast<float>(place[0]), static_cast<float>(place[1])};
}

void take_crowd(const Raw& raw, Options& o) {
  if (!raw.crowd) return;
  if (o.key) throw UserError("--crowd: a crowd cannot have a key; leave PADR_KEY out");
  if (o.join.size() > 1) throw UserError("--join: given more than once; a crowd is joined by one address");
  for (const NetemOverride& n : o.netem_to)
    if (n.peer) throw UserError("--netem-to: peers of a crowd have no number; give HOST:PORT=SPEC");
  if (raw.stroll && !o.input.starts_with("wander"))
    throw UserError("--stroll: is for --input wander only; leave one of them out");
  CrowdOptions& c = o.crowd.emplace();
  c.plane.seed = raw.scenario.seed();
  if (raw.region_side) c.plane.side = static_cast<float>(*raw.region_side);
  c.stroll = raw.stroll.value_or(24);
  Rng rng(shell::unpredictable());
  const double most = 0.75 * static_cast<double>(c.plane.side);
  const auto draw = [&] { return static_cast<float>(rng.uniform(0.25 * static_cast<double>(c.plane.side), most)); };
  c.start = raw.start.empty() ? Vec2{draw(), draw()} : start_of(raw.start, c.plane);
  c.ground = ground_of(c.plane, c.start, c.stroll);
  shell::load_input(o.input, c.ground, 0, c.plane.seed);
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv) {
  Raw raw;
  Options o;
  CLI::App app(kDescription, "padr-peer");
  app.footer(std::string(kFooter) + shell::netem_help() + kFooterEnd);
  shell::add_version_flag(app, "padr-peer");
  declare_session(app, raw, o);
  declare_crowd(app, raw);
  declare_key(app, raw, o);
  raw.scenario.declare(app);
  declare_play(app, o);
  raw.technique.declare(app);
  raw.netem.declare(app);
  app.add_option("--netem-to", raw.netem_to,
                 "Impairment towards one peer, in place of --netem; to an address: of all that goes there; to a\n"
                 "number: of state datagrams, while the peer has this number; may be repeated")
      ->type_name("WHERE=SPEC")
      ->allow_extra_args(false)
      ->group("Network");
  declare_output(app, raw, o);
  declare_monitor(app, raw);
  if (!shell::parse(app, argc, argv)) return std::nullopt;

  check_crowd_flags(app, raw);
  take_log_levels(raw, o);
  take_addresses(raw, o);
  take_key(raw, o);
  take_spectator(app, o);
  take_monitor(raw, o);
  if (!o.monitor && app.count("--monitor-detail") > 0)
    throw UserError("--monitor-detail: there is no monitor to tell; give --monitor, too");
  o.technique = raw.technique.technique();
  o.netem = raw.netem.spec(&o.warnings);
  o.netem_text = raw.netem.text();
  o.netem_seed = raw.netem.seed(raw.scenario.seed());
  std::set<std::string> impaired;
  for (const std::string& text : raw.netem_to) {
    o.netem_to.push_back(parse_override(text, &o.warnings));
    const std::string where = text.substr(0, text.find('='));
    if (!impaired.insert(where).second) throw UserError("--netem-to: given twice for " + where + "; give it once");
    o.netem_text += (o.netem_text.empty() ? "to " : "; to ") + where + ": " + text.substr(where.size() + 1);
  }
  take_crowd(raw, o);
  if (!o.crowd) {
    o.scenario = raw.scenario.load();
    take_sizes(raw, o);
    // Which avatar it will drive is not known yet, but what is wrong with it is the same for all.
    if (o.spectates)
      o.input = "none";
    else
      shell::load_input(o.input, o.scenario.scene, 0, o.scenario.seed);
  }
  o.trace = raw.trace;
  o.json = raw.json;
  o.command = shell::command_of(argc, argv);
  return o;
}

}  // namespace padr::peer
