#include "tools/lab/compare/command.h"

#include <algorithm>
#include <iostream>
#include <optional>

#include "shell/command_line.h"
#include "shell/files.h"
#include "shell/run_main.h"
#include "tools/plot/gnuplot.h"

namespace padr::lab {
namespace {

using namespace compare;

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

}  // namespace

void CompareCommand::declare(CLI::App& app) {
  flags_.declare(app);
  app.add_flag("--processor-time", processor_time_,
               "Also measure the processor time of a peer, against a bare Box2D world in the same run; it differs\n"
               "from run to run");
  app.add_option("--json", json_, "Write all figures to a file, or - for standard output in place of the table")
      ->type_name("FILE|-");
  app.add_option("--csv", csv_, "Write one line for each run to a file, or - for standard output in place of the table")
      ->type_name("FILE|-");
  app.add_option("--out", out_, "Folder for pictures of inconsistency against traffic, and for table, JSON and CSV")
      ->type_name("DIR");
  app.footer(
      help_on_contestants() +
      "snapshot, state-sync, dis, rollback and lockstep follow the descriptions of their authors. They also get\n"
      "what those lack: clocks that agree, PADR's rule of authority by contact, and sealed datagrams of 1,200 bytes\n"
      "at most. The truth of a body is its place in the world of the peer with the best claim at that tick; other\n"
      "peers may not know of the claim yet. Rollback and lockstep have no authority: their truth is what the inputs\n"
      "come to when none is late.\n"
      "Example:\n"
      "  padr-lab compare --out out/compare\n"
      "  padr-lab compare --techniques paper,full --add 'full --lead 0.2' --add 'fixed --unowned agreed'\n"
      "  padr-lab compare --techniques full,dis --netem \"delay 100ms 50ms loss 10%\" --seeds 10 --csv -\n"
      "Exit: 0 done, 1 confirmed worlds differed or gnuplot failed, 2 usage.");
}

int CompareCommand::run(const std::vector<std::string>& command) const {
  Plan p = flags_.plan();
  p.setting.processor_time = processor_time_;
  if (!out_.empty()) plot::write_into("--out", out_, {});
  Sink json_sink("--json", json_);
  Sink csv_sink("--csv", csv_);
  const std::vector<Row> rows = run_plan(p);
  warn_of_unmeasured(rows, p.setting.ticks);
  const std::string all = json(rows, p, shell::shell_line(command));
  json_sink.write(all);
  csv_sink.write(csv(rows, p));
  if (!json_sink.to_terminal() && !csv_sink.to_terminal()) std::cout << table(rows, p);
  plot::Drawing drawing;
  if (!out_.empty()) {
    plot::write_into("--out", out_,
                     {{"compare.json", all}, {"compare.csv", csv(rows, p)}, {"compare.txt", table(rows, p)}});
    drawing = draw_frontiers(rows, p, out_);
    if (!drawing.wrong.empty()) std::cerr << "padr-lab: " << drawing.wrong << '\n';
  }
  const bool agreed = std::all_of(rows.begin(), rows.end(), [](const Row& r) {
    return std::all_of(r.scores.begin(), r.scores.end(), [](const Score& s) { return s.mismatches == 0; });
  });
  return agreed && !drawing.failed ? shell::kExitFine : shell::kExitFailure;
}

}  // namespace padr::lab
