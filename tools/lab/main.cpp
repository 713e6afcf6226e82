#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "shell/command_line.h"
#include "shell/run_main.h"
#include "tools/lab/audit/command.h"
#include "tools/lab/benchmark/command.h"
#include "tools/lab/chaos/command.h"
#include "tools/lab/compare/command.h"
#include "tools/lab/convergence/command.h"
#include "tools/lab/crowd/command.h"
#include "tools/lab/examples/command.h"
#include "tools/lab/figures/command.h"
#include "tools/lab/path.h"
#include "tools/lab/replay.h"
#include "tools/lab/run.h"
#include "tools/lab/sweep/command.h"

namespace {

struct ReplayCommand {
  std::string trace;

  void declare(CLI::App& app) {
    app.add_option("TRACE", trace, "a trace of padr-peer --trace or padr-lab run --trace")->required();
    app.footer(
        "Exit: 0 everything was the same, 1 something differed or could not be written, 2 usage or damaged trace.");
  }
  int run() const { return padr::lab::run_replay(trace); }
};

/// The subcommands; CLI11 sees to it that exactly one of them is given.
struct Commands {
  CLI::App& app;
  std::vector<std::string> line;
  std::function<int()> given;

  template <typename Command>
  void add(const char* name, const char* description, Command& command) {
    CLI::App& sub = *app.add_subcommand(name, description);
    command.declare(sub);
    sub.callback([this, &command] {
      given = [&line = line, &command] {
        static_cast<void>(line);  // not every command wants it
        if constexpr (requires { command.run(line); }) {
          return command.run(line);
        } else {
          return command.run();
        }
      };
    });
  }
};

int lab(int argc, char** argv) {
  CLI::App app{
      "The lab runs the core of N peers in lock step, on a virtual clock and a virtual network.\n"
      "The same seed gives the same run, to the bit."};
  padr::shell::add_version_flag(app, "padr-lab");
  app.require_subcommand(1);
  Commands commands{app, padr::shell::command_of(argc, argv), {}};

  padr::lab::RunCommand run;
  commands.add("run", "one session: consistency and traffic of every peer", run);
  ReplayCommand replay;
  commands.add("replay", "feed a peer's trace to a fresh core and compare every bit", replay);
  padr::lab::AuditCommand audit;
  commands.add("audit", "what members said, held against physics and against one another", audit);
  padr::lab::ExamplesCommand examples;
  commands.add("examples", "the paper's examples: what model errors do to bodies", examples);
  padr::lab::FiguresCommand figures;
  commands.add("figures", "the paper's experiments, with a report that shows them", figures);
  padr::lab::CompareCommand compare;
  commands.add("compare", "techniques, ours and others, on the same inputs and links", compare);
  padr::lab::BenchmarkCommand benchmark;
  commands.add("benchmark", "a comparison others can repeat: inputs, links and results in a folder", benchmark);
  padr::lab::ConvergenceCommand convergence;
  commands.add("convergence", "one session, shown with each method of convergence, with a film", convergence);
  padr::lab::SweepCommand sweep;
  commands.add("sweep", "a grid of runs into one CSV; can be resumed and split into shards", sweep);
  padr::lab::ChaosCommand chaos;
  commands.add("chaos", "random scripts of peers that join, leave and crash, with checks", chaos);
  padr::lab::CrowdCommand crowd;
  commands.add("crowd", "crowds on a plane of regions: the cost of a peer, by crowd size", crowd);
  padr::lab::MergeCommand merge;
  commands.add("merge", "join the shards of a sweep into one CSV", merge);
  padr::lab::PathCommand path;
  commands.add("path", "fit recorded motion in pixels and milliseconds to a scenario", path);

  if (!padr::shell::parse(app, argc, argv)) return padr::shell::kExitFine;
  return commands.given();
}

}  // namespace

int main(int argc, char** argv) {
  return padr::shell::run_main("padr-lab", [argc, argv] { return lab(argc, argv); });
}
