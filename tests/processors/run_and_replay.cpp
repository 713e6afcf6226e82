// `padr-lab run` and `padr-lab replay` alone: all other commands of padr-lab take longer to compile than these.
#include <CLI/CLI.hpp>
#include <string>

#include "shell/command_line.h"
#include "shell/run_main.h"
#include "tools/lab/replay.h"
#include "tools/lab/run.h"

int main(int argc, char** argv) {
  return padr::shell::run_main("padr-lab", [argc, argv] {
    CLI::App app("Two commands of padr-lab.");
    app.require_subcommand(1);
    padr::lab::RunCommand run;
    CLI::App& runs = *app.add_subcommand("run");
    run.declare(runs);
    std::string trace;
    app.add_subcommand("replay")->add_option("TRACE", trace)->required();
    if (!padr::shell::parse(app, argc, argv)) return padr::shell::kExitFine;
    return runs.parsed() ? run.run(padr::shell::command_of(argc, argv)) : padr::lab::run_replay(trace);
  });
}
