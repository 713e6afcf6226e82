#include "common/model/user_error.h"
#include "shell/files.h"
#include "tools/capture/commands.h"
#include "tools/capture/record.h"

namespace padr::capture {
namespace {

constexpr const char* kExportFooter =
    "Fields have the names of the Wireshark dissector. Fields of the outer layers have the names of tshark\n"
    "(frame.number, frame.time_epoch, ip.src, udp.srcport, ...). A field that a datagram can have several times is a\n"
    "list in the order of the datagram; all fields of updates are lists. An update that is passed on stands at its\n"
    "place. padr.cause has for each update the avatar's cause, then the causes of the bodies. Hexadecimal fields are\n"
    "text without 0x; floats read back exactly. A datagram that receivers drop has its envelope, and the reason in\n"
    "padr.drop. A datagram that the capture cut off ends after the envelope. In CSV lists are joined by ';'. A "
    "datagram\n"
    "that is carried for two others has padr.carried.to; there is a record for each of its hops, and the addresses "
    "are\n"
    "those of that hop.\n"
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
  shell::OutputFile file("--out", o.out);
  Recorder recorder;
  if (o.csv) file.write(csv_head());
  while (const Datagram* d = captures.next()) {
    const Record r = recorder.record(*d);
    file.write((o.json ? r.json() : r.csv(all_fields())) + "\n");
  }
  file.close();
  return warn_unread(captures);
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
