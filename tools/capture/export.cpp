#include <cstdio>

#include "common/model/user_error.h"
#include "tools/capture/commands.h"
#include "tools/capture/record.h"
#include "tools/support/files.h"

namespace padr::capture {
namespace {

constexpr const char* kExportFooter =
    "Fields have the names of the Wireshark dissector, and tshark's for what is around (frame.number, "
    "frame.time_epoch,\n"
    "ip.src, udp.srcport, ...). A field that can come several times in a datagram is a list: of what is in updates "
    "all\n"
    "are, in the order of the datagram, what is passed on in its place. padr.cause has first the avatar's cause, then\n"
    "those of the bodies, update by update. hex fields are text without 0x; floats read back exactly. A datagram that\n"
    "receivers drop has its envelope and padr.drop with the reason; one that the capture cut off ends after the\n"
    "envelope. In CSV lists are joined by ';'.\n"
    "\n"
    "Examples:\n"
    "  padr-capture export lo.pcap --json | jq -c 'select(.[\"padr.kind\"] == \"state\") | [.\"padr.tick\", "
    ".\"padr.entity\"]'\n"
    "  padr-capture export lo.pcap --csv --out lo.csv";

struct ExportOptions {
  std::vector<std::string> files;
  std::vector<std::string> keylogs;
  bool json = false;
  bool csv = false;
  std::string out = "-";
};

std::string csv_head() {
  std::string head;
  for (const std::string_view name : all_fields()) head += (head.empty() ? "" : ",") + std::string(name);
  return head + "\n";
}

int run_export(const ExportOptions& o) {
  if (o.json == o.csv) throw UserError("export: give one of --json and --csv");
  for (const std::string& f : o.files)
    if (f.ends_with(".csv") || f.ends_with(".json"))
      throw UserError("CAPTURE: " + f + " is no capture; the file to write is --out " + f);
  Captures captures(o.files, o.keylogs);
  std::unique_ptr<support::OutputFile> file;
  if (o.out != "-") file = std::make_unique<support::OutputFile>("--out", o.out);
  const auto write = [&file](const std::string& text) {
    if (file) return file->write(text);
    std::fwrite(text.data(), 1, text.size(), stdout);
  };
  Recorder recorder;
  if (o.csv) write(csv_head());
  while (const Datagram* d = captures.next()) {
    const Record r = recorder.record(*d);
    write((o.json ? r.json() : r.csv(all_fields())) + "\n");
  }
  if (file) file->close();
  std::fflush(stdout);
  return warn_incomplete(captures.troubles());
}

}  // namespace

Run declare_export(CLI::App& app) {
  const auto o = std::make_shared<ExportOptions>();
  declare_captures(app, o->files, o->keylogs);
  app.footer(kExportFooter);
  app.add_flag("--json", o->json, "One JSON object a line");
  app.add_flag("--csv", o->csv, "One row a datagram, a column for every field there is");
  app.add_option("--out", o->out, "- is standard output")->type_name("FILE|-")->capture_default_str();
  return [o](const std::vector<std::string>&) { return run_export(*o); };
}

}  // namespace padr::capture
