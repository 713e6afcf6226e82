#include <cstdio>
#include <string>
#include <vector>

#include "shell/command_line.h"
#include "shell/files.h"
#include "shell/run_main.h"
#include "tools/report/analysis.h"
#include "tools/report/files.h"
#include "tools/report/options.h"
#include "tools/report/outputs.h"

namespace padr::report {
namespace {

int run(const Options& o, const std::vector<std::string>& command) {
  std::vector<TraceBytes> traces;
  const auto note = [](const std::string& text) { std::fprintf(stderr, "padr-report: %s\n", text.c_str()); };
  for (const std::string& file : shell::without_empty(o.traces, note)) traces.push_back(read_trace(file));
  const Report r = analyse(traces);
  if (o.json != "-") std::fputs(table(r).c_str(), stdout);
  if (!o.json.empty()) shell::write_text("--json", o.json, json(r, command));
  if (!o.csv.empty()) plot::write_into("--csv", o.csv, csv_files(r));
  plot::Drawing drawing;
  if (!o.plots.empty()) {
    plot::write_into("--plots", o.plots, plot_files(r));
    drawing = plot::draw(o.plots, plot_names());
    if (!drawing.wrong.empty()) std::fprintf(stderr, "padr-report: %s\n", drawing.wrong.c_str());
  }
  if (r.confirmed.mismatches == 0) return drawing.failed ? shell::kExitFailure : shell::kExitFine;
  std::fprintf(stderr, "padr-report: CONFIRMED WORLDS DIFFER, first at tick %d: %s\n", r.confirmed.first_mismatch,
               r.confirmed.who.c_str());
  return shell::kExitFailure;
}

}  // namespace
}  // namespace padr::report

int main(int argc, char** argv) {
  return padr::shell::run_main("padr-report", [argc, argv] {
    const auto options = padr::report::parse_options(argc, argv);
    if (!options) return padr::shell::kExitFine;
    return padr::report::run(*options, padr::shell::command_of(argc, argv));
  });
}
