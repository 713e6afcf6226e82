#include "tools/lab/sweep/command.h"

#include <cstdio>

#include "common/model/user_error.h"
#include "shell/command_line.h"
#include "shell/files.h"
#include "shell/run_main.h"
#include "shell/scenario_flags.h"
#include "shell/technique_flags.h"
#include "tools/lab/sweep/digest.h"
#include "tools/lab/sweep/sweep.h"

namespace padr::lab {
namespace {

constexpr double kMaxSeconds = 24 * 3600;
constexpr const char* kSummaryHelp =
    "Write means over seeds to a CSV, one row for each combination;\nX_interval is half of the 95 % interval of X";

/// The table on standard output, and the summary's file if there is to be one.
void sum_up(const sweep::StoredRows& rows, const std::string& summary) {
  if (const std::string doubt = sweep::doubt(rows); !doubt.empty())
    std::fprintf(stderr, "padr-lab: warning: %s\n", doubt.c_str());
  std::fputs(sweep::digest(rows).c_str(), stdout);
  if (!summary.empty()) sweep::replace_file("--summary", summary, sweep::summary(rows));
}

/// The exit code of a file with these rows, whenever they were played.
int exit_of(const sweep::StoredRows& rows) {
  if (sweep::agreed(rows)) return shell::kExitFine;
  std::fprintf(stderr, "padr-lab: confirmed worlds differed: see the column confirmed_mismatches\n");
  return shell::kExitFailure;
}

void declare_network(CLI::App& app, sweep::GridText& grid) {
  const std::string group = "Network (of every directed link)";
  app.add_option("--delay", grid.delay, "One-way delays, 0 to 60 s, such as 0,50,100ms")
      ->type_name("TIMES")
      ->group(group);
  app.add_option("--jitter", grid.jitter, "Delays vary by this much up and down, 0 to 60 s")
      ->type_name("TIMES")
      ->group(group);
  app.add_option("--loss", grid.loss, "Datagrams lost, 0 to 100 %, such as 0,5,10%")
      ->type_name("PERCENTS")
      ->group(group);
  app.add_option("--netem", grid.netem,
                 "Further impairments of every run, in the grammar of tc-netem, such as 'duplicate 1%'")
      ->type_name("SPEC")
      ->group(group);
}

void declare_technique(CLI::App& app, sweep::GridText& grid) {
  const std::string group = "Technique";
  app.add_option("--technique", grid.techniques,
                 "Names, as for padr-lab run; each may set its own knobs,\nsuch as 'fixed --threshold 0.8,adaptive'")
      ->type_name("NAMES")
      ->capture_default_str()
      ->group(group);
  for (std::size_t k = 0; k < shell::knobs().size(); ++k) {
    const shell::Knob& knob = shell::knobs()[k];
    app.add_option(knob.flag, grid.knobs[k], knob.help)->type_name(std::string(knob.type) + ",...")->group(group);
  }
}

}  // namespace

SweepCommand::SweepCommand() {
  grid_.knobs.resize(shell::knobs().size());
}

void SweepCommand::declare(CLI::App& app) {
  const std::string world = "World";
  app.add_option("--scenario", grid_.scenarios, "Built-in names or files")
      ->type_name("NAMES|FILES")
      ->capture_default_str()
      ->group(world);
  app.add_option("--bodies", grid_.bodies, "Numbers of bodies, 1 to 5000: change the scenario's scatter or row")
      ->type_name("COUNTS")
      ->group(world);
  app.add_option("--peers", grid_.peers,
                 "Numbers of peers, 1 to 64, and at most as many as the scenario has spawn points")
      ->type_name("COUNTS")
      ->capture_default_str()
      ->group(world);
  app.add_option("--seeds", grid_.seeds,
                 "Seeds of scenario, network and generated input, such as 1-20; 20 alone is one seed")
      ->type_name("NUMBERS")
      ->capture_default_str()
      ->group(world);
  app.add_option("--input", grid_.inputs, std::string(shell::kInputHelp) + "; repeat for more peers, in turn")
      ->type_name("SPEC")
      ->group(world);
  declare_network(app, grid_);
  declare_technique(app, grid_);
  app.add_option("--seconds", grid_.seconds, "Virtual time with input in every run, s")
      ->check(shell::between(0.1, kMaxSeconds, "seconds"))
      ->capture_default_str();
  app.add_option("--settle", grid_.settle_seconds, "Virtual seconds without input after that")
      ->check(shell::between(0, kMaxSeconds, "seconds"))
      ->capture_default_str();
  app.add_option(
         "--watch", grid_.watch,
         "Inconsistency in the view of this peer alone, and only while there is input; all else over the whole run")
      ->type_name("PEER");
  app.add_option("--csv", csv_, "File for the rows; runs that have a row there already are skipped")->type_name("FILE");
  app.add_option("--summary", summary_, kSummaryHelp)->type_name("FILE");
  app.add_option("--shard", shard_, "Run only part I of N, I from 1 to N; padr-lab merge joins the parts")
      ->type_name("I/N");
  app.add_option("--jobs", jobs_, "Runs at once; default: one for each processor")->check(shell::range(1, 1024));
  app.add_flag("--dry-run", dry_, "Check the grid and say how many runs it has; run nothing");
  app.footer(
      "Lists have commas between their values. Every combination is one run and gives one row. The same grid gives "
      "the\n"
      "same file to the byte, with any interruptions and any number of shards.\n"
      "Example:\n"
      "  padr-lab sweep --delay 0,50,100ms --loss 0,5,10% --threshold 0.8,0.3:0.1 --peers 2,4 --bodies 20,60 \\\n"
      "    --seeds 1-5 --seconds 30 --csv out/grid.csv --summary out/means.csv\n"
      "  padr-lab sweep ... --shard 2/8 --csv out/part2.csv      and the seven others, on any machine; then\n"
      "  padr-lab merge out/part*.csv --out out/grid.csv\n"
      "Exit: 0 done, 1 confirmed worlds differed or a file could not be written, 2 usage.");
}

int SweepCommand::run() {
  const sweep::Grid grid(grid_);
  const sweep::Shard shard = sweep::shard_of(shard_);
  for (const std::string& w : grid.warnings()) std::fprintf(stderr, "padr-lab: warning: in some runs: %s\n", w.c_str());
  if (dry_) {
    std::printf("grid %s: %zu runs\n", grid.id().c_str(), grid.size());
    return shell::kExitFine;
  }
  if (csv_.empty()) throw UserError("--csv is required: the file for the rows (or give --dry-run)");
  if (!summary_.empty() && shard.count > 1)
    throw UserError("--summary with --shard: a shard does not have all seeds; give --summary to padr-lab merge");
  if (!summary_.empty()) shell::replaceable("--summary", summary_);  // not only after all runs
  ParallelOptions parallel;
  parallel.threads = jobs_;
  const sweep::SweepResult r = sweep::run_sweep(grid, shard, csv_, parallel);
  std::printf("grid %s: %zu of %zu runs in %s, %zu of them new\n", grid.id().c_str(), r.runs, grid.size(), csv_.c_str(),
              r.done_now);
  const sweep::StoredRows rows = sweep::read_rows("--csv", csv_);
  if (shard.count == 1) sum_up(rows, summary_);
  return exit_of(rows);
}

void MergeCommand::declare(CLI::App& app) {
  app.add_option("SHARD", shards_, "The files of all shards of one sweep, in any order")
      ->type_name("FILE ...")
      ->required();
  app.add_option("--out", out_, "File for the joined rows")->type_name("FILE")->required();
  app.add_option("--summary", summary_, kSummaryHelp)->type_name("FILE");
  app.footer(
      "Refuses files of different grids, double runs and missing runs. Otherwise it writes the same bytes as one\n"
      "padr-lab sweep without --shard.\n"
      "Example:\n"
      "  padr-lab merge out/part*.csv --out out/grid.csv\n"
      "Exit: 0 done, 1 confirmed worlds differed or a file could not be written, 2 usage, or the shards are not "
      "complete.");
}

int MergeCommand::run() {
  if (!summary_.empty()) shell::replaceable("--summary", summary_);
  const std::size_t runs = sweep::merge(shards_, out_);
  std::printf("%zu runs of %zu files in %s\n", runs, shards_.size(), out_.c_str());
  const sweep::StoredRows rows = sweep::read_rows("--out", out_);
  sum_up(rows, summary_);
  return exit_of(rows);
}

}  // namespace padr::lab
