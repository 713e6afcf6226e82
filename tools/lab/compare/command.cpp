#include "tools/lab/compare/command.h"

#include <algorithm>
#include <iostream>

#include "shell/command_line.h"
#include "shell/files.h"
#include "shell/run_main.h"
#include "tools/plot/gnuplot.h"

namespace padr::lab {

using namespace compare;

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
      "Exit: 0 done, 1 confirmed worlds differed, gnuplot failed or a file could not be written, 2 usage.");
}

int CompareCommand::run(const std::vector<std::string>& command) const {
  Plan p = flags_.plan();
  p.setting.processor_time = processor_time_;
  if (!out_.empty()) plot::write_into("--out", out_, {});  // the other files may lie in it
  shell::check_writable("--json", json_);
  shell::check_writable("--csv", csv_);
  const std::vector<Row> rows = run_plan(p);
  warn_of_unmeasured(rows, p.setting.ticks);
  const std::string all = json(rows, p, shell::shell_line(command));
  const auto write = [](const char* flag, const std::string& file, const std::string& text) {
    if (!file.empty()) shell::write_text(flag, file, text);
  };
  if (json_ != "-" && csv_ != "-") std::cout << table(rows, p);
  shell::do_all({[&] { write("--json", json_, all); }, [&] { write("--csv", csv_, csv(rows, p)); }});
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
