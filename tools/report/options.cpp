#include "tools/report/options.h"

#include <CLI/CLI.hpp>

#include "tools/support/command_line.h"

namespace padr::report {
namespace {

constexpr const char* kDescription =
    "How consistent the peers of a session were and what it cost, from their traces: inconsistency, traffic by cause,\n"
    "links, and whether every confirmed world was the same on all peers.";

constexpr const char* kFooter =
    "Traces are what padr-peer --trace FILE and padr-lab run --trace DIR write. Give those of all peers of a session:\n"
    "what a peer owns is measured against that peer's own view. A trace that breaks off is used as far as it goes.\n"
    "\n"
    "Inconsistency: per tick, the sum over all entities of the distance between a peer's view and the view of the\n"
    "entity's owner at the same session tick. For a body that nobody owns it is the distance to the agreed world, or,\n"
    "with --unowned live, the mean distance to all other peers' views. Below about 5 mm (Box2D's slop) it is noise.\n"
    "A peer is measured until it says goodbye.\n"
    "\n"
    "Fidelity error: how far bodies are from where the players' deeds alone put them: each player's live world is "
    "copied\n"
    "and stepped for a second with what the player really did. Physics-consistency-cost: by how much others' views "
    "differ\n"
    "in the bodies that an avatar disturbed. docs/metrics.md defines both.\n"
    "\n"
    "Examples:\n"
    "  padr-report out/demo/peer*.trace\n"
    "  padr-report out/demo/peer*.trace --plots out/plots --csv out/csv --json out/report.json\n"
    "  padr-report out/demo/peer*.trace --json - | jq .mean_m\n"
    "\n"
    "Exit code: 0 if all confirmed worlds were identical, 1 if they differ, 2 if the command line is wrong or a trace\n"
    "cannot be used.";

}  // namespace

std::optional<Options> parse_options(int argc, char** argv) {
  Options o;
  CLI::App app(kDescription, "padr-report");
  app.footer(kFooter);
  support::add_version_flag(app, "padr-report");
  app.add_option("TRACE", o.traces, "Traces of the peers of one session")->required()->type_name("FILE");
  app.add_option("--json", o.json, "Write everything as JSON; - for standard output, in place of the table")
      ->type_name("FILE|-");
  app.add_option("--csv", o.csv,
                 "Write inconsistency.csv, fidelity.csv, traffic.csv, links.csv and authority.csv there")
      ->type_name("DIR");
  app.add_option("--plots", o.plots, "Draw inconsistency, traffic and authority as SVG and PNG there (gnuplot)")
      ->type_name("DIR");
  if (!support::parse(app, argc, argv)) return std::nullopt;
  return o;
}

}  // namespace padr::report
