#include "tools/lab/benchmark/command.h"

#include <algorithm>
#include <cstdio>
#include <iostream>

#include "shell/command_line.h"
#include "shell/run_main.h"
#include "tools/lab/benchmark/benchmark.h"
#include "tools/lab/benchmark/material.h"
#include "tools/lab/benchmark/page.h"
#include "tools/plot/gnuplot.h"

namespace padr::lab {

void BenchmarkCommand::declare(CLI::App& app) {
  flags_.declare(app);
  app.add_option("--out", out_, "Folder for inputs, links, results and their page; runs that it has are not repeated")
      ->type_name("DIR")
      ->required();
  app.add_flag("--dry-run", dry_, "Check the flags and say how many runs there are; run nothing");
  app.footer(
      compare::help_on_contestants() +
      "In the folder: results.csv (a row for each run), results.json (means), results.txt (tables), index.html,\n"
      "inputs/ and links/ (what others need to play the same). Processor time differs from run to run; all else\n"
      "is the same to the bit. A benchmark that was stopped goes on where it was.\n"
      "Example:\n"
      "  padr-lab benchmark --out out/benchmark\n"
      "  padr-lab benchmark --techniques full,rollback-2 --seeds 1 --seconds 10 --out out/short\n"
      "Exit: 0 done, 1 confirmed worlds differed, gnuplot failed or a file could not be written, 2 usage.");
}

int BenchmarkCommand::run(const std::vector<std::string>& command) const {
  const benchmark::Benchmark b(flags_.plan());
  const std::string file = out_ + "/results.csv";
  if (dry_) {
    std::printf("benchmark %s: %zu runs\n", b.id().c_str(), b.size());
    return shell::kExitFine;
  }
  const sweep::SweepResult done = b.run(file);
  benchmark::write_material(b.plan(), out_);
  const std::vector<compare::Row> rows = b.rows(file);
  compare::warn_of_unmeasured(rows, b.plan().setting.ticks);
  const std::string line = shell::shell_line(command);
  plot::write_into("--out", out_,
                   {{"results.json", compare::json(rows, b.plan(), line)},
                    {"results.txt", compare::table(rows, b.plan())},
                    {"index.html", benchmark::page(rows, b.plan(), line, b.id())}});
  const plot::Drawing drawing = compare::draw_frontiers(rows, b.plan(), out_);
  if (!drawing.wrong.empty()) std::cerr << "padr-lab: " << drawing.wrong << '\n';
  std::printf("benchmark %s: %zu runs in %s, %zu of them new; see %s/index.html\n", b.id().c_str(), done.runs,
              file.c_str(), done.done_now, out_.c_str());
  const bool agreed = std::all_of(rows.begin(), rows.end(), [](const compare::Row& r) {
    return std::all_of(r.scores.begin(), r.scores.end(), [](const compare::Score& s) { return s.mismatches == 0; });
  });
  return agreed && !drawing.failed ? shell::kExitFine : shell::kExitFailure;
}

}  // namespace padr::lab
