#include "tools/report/options.h"

#include <CLI/CLI.hpp>

#include "shell/command_line.h"

namespace padr::report {
namespace {

constexpr const char* kDescription =
    "Reports from the traces of a session: inconsistency of the peers, traffic by cause, links, and whether every\n"
    "confirmed world was the same on all peers.";

constexpr const char* kFooter =
    "padr-peer --trace FILE and padr-lab run --trace DIR write traces. Give the traces of all peers of a session,\n"
    "because the truth of an entity is in its owner's trace. A trace that breaks off is used as far as it goes;\n"
    "an empty one, of a peer that has not got into the session, is left out beside others.\n"
    "\n"
    "Inconsistency is a sum over all entities at a tick: the distance between the entity in a peer's view and in its\n"
    "owner's view at the same session tick. For a body that nobody owns the truth is the agreed world; with --unowned\n"
    "live its term is the mean distance to all other peers' views. Inconsistency below about 5 mm is noise, because\n"
    "Box2D lets bodies overlap by so much. A peer is measured until it leaves.\n"
    "\n"
    "Fidelity error is the distance between bodies in a view and the same bodies after the players' deeds alone. For\n"
    "this each player's live world is copied and stepped for a second with the player's real input.\n"
    "Physics-consistency-cost is the difference between others' views and the player's own view, in the bodies that\n"
    "the player's avatar disturbed. docs/metrics.md defines both.\n"
    "\n"
    "Examples:\n"
    "  padr-report out/demo/peer*.trace\n"
    "  padr-report out/demo/peer*.trace --plots out/plots --csv out/csv --json out/report.json\n"
    "  padr-report out/demo/peer*.trace --json - | jq .mean_m\n"
    "\n"
    "Exit code: 0 if all confirmed worlds were identical, 1 if they differ, gnuplot failed or a file could not be\n"
    "written, 2 if the command line is wrong or a trace cannot be used.";

}  // namespace

std::optional<Options> parse_options(int argc, char** argv) {
  Options o;
  CLI::App app(kDescription, "padr-report");
  app.footer(kFooter);
  shell::add_version_flag(app, "padr-report");
  app.add_option("TRACE", o.traces, "Traces of the peers of one session")->required()->type_name("FILE");
  app.add_option("--json", o.json, "Write everything as JSON; - for standard output, in place of the table")
      ->type_name("FILE|-");
  app.add_option("--csv", o.csv,
                 "Write inconsistency.csv, fidelity.csv, traffic.csv, links.csv and authority.csv to this folder")
      ->type_name("DIR");
  app.add_option("--plots", o.plots,
                 "Draw inconsistency, traffic and authority as SVG and PNG in this folder (needs gnuplot)")
      ->type_name("DIR");
  if (!shell::parse(app, argc, argv)) return std::nullopt;
  return o;
}

}  // namespace padr::report
