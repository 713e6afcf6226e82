#include "tools/lab/audit/command.h"

#include <cstdio>
#include <iostream>
#include <span>

#include "shell/command_line.h"
#include "shell/files.h"
#include "shell/run_main.h"
#include "tools/lab/audit/report_text.h"
#include "tools/lab/replay.h"

namespace padr::lab {

void AuditCommand::declare(CLI::App& app) {
  app.add_option("TRACE", traces_, "Traces of peers of one session, one or more: the more, the more is found")
      ->required();
  app.add_option("--worst", worst_, "Findings of a member to print of each kind, the worst")
      ->check(shell::range(1, 1000000))
      ->capture_default_str();
  app.add_flag("--no-pushes", no_pushes_,
               "Nobody could push bodies in the session: what looks like a push is a claim like any other");
  app.add_option("--json", json_, "All findings to a file, or - for standard output in place of the report")
      ->type_name("FILE|-");
  app.footer(
      "Plays each trace again, and looks for what no honest member says: two different updates with one number; an\n"
      "avatar that moves faster or farther than its scene lets it; a claim of a body that the member's avatar cannot\n"
      "have touched; a body with a speed, or in a place, that contacts do not give. In a session with a key, "
      "signatures\n"
      "tell what is proof. docs/audit.md has the limits, and how small a lie is found.\n"
      "Each line has the tick, the number of the update, what was measured and what is possible, margins included, "
      "and\n"
      "the traces that it stands in.\n"
      "Examples:\n"
      "  padr-lab audit out/peer0.trace\n"
      "  padr-lab audit out/*.trace --json findings.json\n"
      "Exit: 0 nothing found, 1 something found or a file could not be written, 2 usage or damaged trace.");
}

int AuditCommand::run(const std::vector<std::string>& command) const {
  shell::check_writable("--json", json_);
  const auto note = [](const std::string& text) { std::fprintf(stderr, "padr-lab: %s\n", text.c_str()); };
  const std::vector<std::string> traces = shell::without_empty(traces_, note);
  std::vector<std::string> contents;
  for (const std::string& file : traces) contents.push_back(read_trace_file(file));
  std::vector<audit::TraceText> texts;
  for (std::size_t i = 0; i < traces.size(); ++i) texts.push_back({traces[i], std::as_bytes(std::span(contents[i]))});
  audit::Options options;
  options.pushes = !no_pushes_;
  const audit::Report report = audit::audit(texts, options);
  if (json_ != "-") std::cout << audit::text(report, worst_);
  if (!json_.empty()) shell::write_text("--json", json_, audit::json(report, command));
  return report.findings.empty() ? shell::kExitFine : shell::kExitFailure;
}

}  // namespace padr::lab
