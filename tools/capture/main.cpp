#include <CLI/CLI.hpp>

#include "shell/command_line.h"
#include "shell/run_main.h"
#include "tools/capture/commands.h"

namespace {

constexpr const char* kDescription =
    "Analyses a session from its packets alone, in pcap and pcapng files of tcpdump, Wireshark or padr-peer --pcap.\n"
    "It reads any port; Ethernet with VLAN tags, Linux cooked (-i any), loopback and raw IP; IPv4 and IPv6; and files\n"
    "that are still being written.";

constexpr const char* kFooter =
    "Examples:\n"
    "  padr-capture summary peer*.pcapng\n"
    "  padr-capture rebuild peer0.pcapng --svg world.svg\n"
    "  padr-capture compare peer0.pcapng peer*.trace\n"
    "  tcpdump -U -i any -w - udp | padr-capture follow -\n"
    "Each command explains itself with --help.\n"
    "\n"
    "Exit code: 0 on success; 1 if a capture is damaged or breaks off, or if a comparison fails; 2 if the command "
    "line\n"
    "is wrong, or if a file cannot be used or has no session where the command needs one. The result of a damaged\n"
    "capture is about its readable part, and says so.";

int capture(int argc, char** argv) {
  using namespace padr;
  CLI::App app(kDescription, "padr-capture");
  app.footer(kFooter);
  shell::add_version_flag(app, "padr-capture");
  app.require_subcommand(1);
  struct Command {
    const char* name;
    const char* help;
    capture::Run (*declare)(CLI::App&);
  };
  constexpr Command kCommands[] = {
      {"summary", "peers, links, delays, losses and the use of the bytes", capture::declare_summary},
      {"timeline", "joins, leaves, contacts, owners and resends in time", capture::declare_timeline},
      {"rebuild", "rebuild the confirmed world from the packets, and compare it with the peers' hashes",
       capture::declare_rebuild},
      {"compare", "compare a capture with the peers' own traces", capture::declare_compare},
      {"export", "every datagram with every field, for programs", capture::declare_export},
      {"follow", "print a line for every datagram of a capture that is being written", capture::declare_follow},
  };
  std::vector<std::pair<CLI::App*, capture::Run>> runs;
  for (const Command& c : kCommands) {
    CLI::App* sub = app.add_subcommand(c.name, c.help);
    runs.emplace_back(sub, c.declare(*sub));
  }
  if (!shell::parse(app, argc, argv)) return shell::kExitFine;
  for (const auto& [sub, run] : runs)
    if (sub->parsed()) return run(shell::command_of(argc, argv));
  return shell::kExitUsage;
}

}  // namespace

int main(int argc, char** argv) {
  return padr::shell::run_main("padr-capture", [argc, argv] { return capture(argc, argv); });
}
