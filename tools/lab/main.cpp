#include <CLI/CLI.hpp>

#include "tools/lab/chaos/command.h"
#include "tools/lab/compare/command.h"
#include "tools/lab/convergence/command.h"
#include "tools/lab/crowd/command.h"
#include "tools/lab/examples/command.h"
#include "tools/lab/figures/command.h"
#include "tools/lab/replay.h"
#include "tools/lab/run.h"
#include "tools/lab/sweep/command.h"
#include "tools/support/command_line.h"
#include "tools/support/run_main.h"

namespace {

int lab(int argc, char** argv) {
  CLI::App app{
      "padr-lab: the core of padr-peer, N times in lock step on a virtual clock and network.\n"
      "The same seed gives the same run, to the bit."};
  padr::support::add_version_flag(app, "padr-lab");
  app.require_subcommand(1);

  padr::lab::RunCommand run;
  CLI::App& run_app = *app.add_subcommand("run", "one session: consistency and traffic of every peer");
  run.declare(run_app);

  std::string trace;
  CLI::App& replay_app = *app.add_subcommand("replay", "feed a peer's trace to a fresh core and compare every bit");
  replay_app.add_option("TRACE", trace, "a trace of padr-peer --trace or padr-lab run --trace")->required();
  replay_app.footer("Exit: 0 everything was the same, 1 something differed, 2 usage or damaged trace.");

  padr::lab::ExamplesCommand examples;
  CLI::App& examples_app = *app.add_subcommand("examples", "the paper's examples: what model errors do to bodies");
  examples.declare(examples_app);

  padr::lab::FiguresCommand figures;
  CLI::App& figures_app = *app.add_subcommand("figures", "the paper's experiments, with a report that shows them");
  figures.declare(figures_app);

  padr::lab::CompareCommand compare;
  CLI::App& compare_app = *app.add_subcommand("compare", "techniques, ours and others, on the same inputs and links");
  compare.declare(compare_app);

  padr::lab::ConvergenceCommand convergence;
  CLI::App& convergence_app =
      *app.add_subcommand("convergence", "one session as every method of convergence shows it, with a film");
  convergence.declare(convergence_app);

  padr::lab::SweepCommand sweep;
  CLI::App& sweep_app = *app.add_subcommand("sweep", "a grid of runs into one CSV, resumable, in shards if you like");
  sweep.declare(sweep_app);
  padr::lab::ChaosCommand chaos;
  CLI::App& chaos_app = *app.add_subcommand("chaos", "peers that come, go, crash and lose one another: what must hold");
  chaos.declare(chaos_app);
  padr::lab::CrowdCommand crowd;
  CLI::App& crowd_app = *app.add_subcommand("crowd", "crowds on a plane of regions: what a peer costs, by their size");
  crowd.declare(crowd_app);
  padr::lab::MergeCommand merge;
  CLI::App& merge_app = *app.add_subcommand("merge", "the shards of a sweep into one CSV");
  merge.declare(merge_app);

  if (!padr::support::parse(app, argc, argv)) return padr::support::kExitFine;
  if (replay_app.parsed()) return padr::lab::run_replay(trace);
  if (examples_app.parsed()) return examples.run(padr::support::command_of(argc, argv));
  if (figures_app.parsed()) return figures.run();
  if (compare_app.parsed()) return compare.run(padr::support::command_of(argc, argv));
  if (convergence_app.parsed()) return convergence.run();
  if (sweep_app.parsed()) return sweep.run();
  if (chaos_app.parsed()) return chaos.run(padr::support::command_of(argc, argv));
  if (crowd_app.parsed()) return crowd.run(padr::support::command_of(argc, argv));
  if (merge_app.parsed()) return merge.run();
  return run.run(padr::support::command_of(argc, argv));
}

}  // namespace

int main(int argc, char** argv) {
  return padr::support::run_main("padr-lab", [argc, argv] { return lab(argc, argv); });
}
