#include "tools/lab/compare/command.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>

#include "shell/command_line.h"
#include "shell/files.h"
#include "shell/netem_flags.h"
#include "shell/run_main.h"
#include "shell/scenario_flags.h"
#include "tools/lab/compare/alternative_text.h"
#include "tools/plot/gnuplot.h"

namespace padr::lab {
namespace {

using namespace compare;

constexpr double kMaxSeconds = 24 * 3600;

/// A file for results. It is opened before the runs, so that a wrong path shows at once.
class Sink {
 public:
  Sink(const std::string& flag, const std::string& path) : to_terminal_(path == "-") {
    if (!path.empty() && !to_terminal_) file_.emplace(flag, path);
  }
  bool to_terminal() const { return to_terminal_; }
  void write(const std::string& text) {
    if (to_terminal_) std::cout << text;
    if (!file_) return;
    file_->write(text);
    file_->close();
  }

 private:
  bool to_terminal_;
  std::optional<shell::OutputFile> file_;
};

std::string help_on_contestants() {
  std::string text = "Techniques:\n";
  for (const Contestant& c : all_contestants())
    text += "  " + c.id + std::string(c.id.size() < 23 ? 23 - c.id.size() : 1, ' ') + c.what + "\n";
  return text;
}

}  // namespace

void CompareCommand::declare(CLI::App& app) {
  app.add_option("--scenario", scenario_, "Built-in name, or a file")->type_name("NAME|FILE")->capture_default_str();
  app.add_option("--peers", peers_, "Peers")->check(CLI::Range(1, kMaxPeers))->capture_default_str();
  app.add_option("--seconds", seconds_, "Virtual time of every run, s")
      ->check(shell::between(0.1, kMaxSeconds, "seconds"))
      ->capture_default_str();
  app.add_option("--seeds", seeds_, "Average N runs, with the seeds 1, 2, ... for scenario, input and network")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  app.add_option("--netem", netem_,
                 "Impairment of datagrams, in the grammar of tc-netem; repeat for several networks;\n"
                 "default: delay 0ms, 50ms, 100ms and 250ms")
      ->type_name("SPEC")
      ->allow_extra_args(false);
  app.add_option("--input", inputs_, std::string(shell::kInputHelp) + "; repeat for more peers, in turn")
      ->type_name("SPEC")
      ->allow_extra_args(false);
  app.add_option(
         "--techniques", techniques_,
         "Some of: paper, ours, ablations, alternatives; all, which is these four; frontier, which has full at\n"
         "several budgets and further points of the alternatives' curves; or names of those below")
      ->type_name("LIST")
      ->capture_default_str();
  app.add_option("--add", added_,
                 "A further technique or alternative, with its knobs, such as 'full --lead 0.2' or\n"
                 "'rollback --input-delay 3 --hz 20'; may be repeated")
      ->type_name("TECHNIQUE")
      ->allow_extra_args(false);
  app.add_flag("--processor-time", processor_time_,
               "Also measure the processor time of a peer, against a bare Box2D world in the same run; it differs\n"
               "from run to run");
  app.add_option("--jobs", jobs_, "Runs at once; default: one for each processor")->check(CLI::Range(1, 1024));
  app.add_option("--json", json_, "Write all figures to a file, or - for standard output in place of the table")
      ->type_name("FILE|-");
  app.add_option("--csv", csv_, "Write one line for each run to a file, or - for standard output in place of the table")
      ->type_name("FILE|-");
  app.add_option("--out", out_, "Folder for pictures of inconsistency against traffic, and for table, JSON and CSV")
      ->type_name("DIR");
  app.footer(help_on_contestants() + "Alternatives with their knobs, for --add:\n" + help_on_alternatives() +
             "snapshot, state-sync, dis, rollback and lockstep follow the descriptions of their authors. They also get "
             "what those lack: "
             "clocks that\n"
             "agree, PADR's rule of authority by contact, and sealed datagrams of 1,200 bytes at most. The truth of a "
             "body is\n"
             "its place in the world of the peer with the best claim at that tick; other peers may not know of the "
             "claim yet. Rollback and lockstep have no authority: their truth is what the inputs come to when none is "
             "late.\n"
             "Example:\n"
             "  padr-lab compare --out out/compare\n"
             "  padr-lab compare --techniques paper,full --add 'full --lead 0.2' --add 'fixed --unowned agreed'\n"
             "  padr-lab compare --techniques full,dis --netem \"delay 100ms 50ms loss 10%\" --seeds 10 --csv -\n"
             "Exit: 0 done, 1 confirmed worlds differed, 2 usage.");
}

compare::Plan CompareCommand::plan() const {
  Plan p;
  p.contestants = chosen_contestants(techniques_);
  for (const std::string& text : added_) p.contestants.push_back(added_contestant(text));
  const std::vector<std::string> usual{"delay 0ms", "delay 50ms", "delay 100ms", "delay 250ms"};
  for (const std::string& text : netem_.empty() ? usual : netem_) {
    std::vector<std::string> warnings;
    p.networks.push_back({text, shell::parse_netem_flag("--netem", text, &warnings)});
    for (const std::string& w : warnings) std::cerr << "padr-lab: warning: " << w << '\n';
  }
  p.setting.scenario = scenario_;
  p.setting.peers = peers_;
  p.setting.processor_time = processor_time_;
  p.setting.ticks = static_cast<Tick>(std::lround(seconds_ * kTicksPerSecond));
  if (!inputs_.empty()) {
    p.setting.inputs = inputs_;
    shell::tell_of_paths("padr-lab", inputs_, shell::load_scenario(scenario_, 1).scene);
  }
  for (int s = 1; s <= seeds_; ++s) p.seeds.push_back(static_cast<std::uint64_t>(s));
  p.parallel.threads = jobs_;
  return p;
}

int CompareCommand::run(const std::vector<std::string>& command) const {
  const Plan p = plan();
  if (!out_.empty()) plot::write_into("--out", out_, {});
  Sink json_sink("--json", json_);
  Sink csv_sink("--csv", csv_);
  const std::vector<Row> rows = run_plan(p);
  const std::string all = json(rows, p, shell::shell_line(command));
  json_sink.write(all);
  csv_sink.write(csv(rows, p));
  if (!json_sink.to_terminal() && !csv_sink.to_terminal()) std::cout << table(rows, p);
  if (!out_.empty()) {
    plot::write_into("--out", out_,
                     {{"compare.json", all}, {"compare.csv", csv(rows, p)}, {"compare.txt", table(rows, p)}});
    const std::string wrong = draw_frontiers(rows, p, out_);
    if (!wrong.empty()) std::cerr << "padr-lab: " << wrong << '\n';
  }
  const bool agreed = std::all_of(rows.begin(), rows.end(), [](const Row& r) {
    return std::all_of(r.scores.begin(), r.scores.end(), [](const Score& s) { return s.mismatches == 0; });
  });
  return agreed ? shell::kExitFine : shell::kExitFailure;
}

}  // namespace padr::lab
