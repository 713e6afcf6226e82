#include <cstdint>
#include <cstdio>

#include "shell/files.h"
#include "shell/run_main.h"
#include "tools/capture/commands.h"
#include "tools/capture/rebuild_output.h"
#include "tools/capture/setting.h"

namespace padr::capture {
namespace {

constexpr const char* kRebuildFooter =
    "The program folds every update in the packets into the confirmed world, as every peer does. It compares this\n"
    "world with the hashes in the packets. It begins with the start of the session. If the capture does not have the\n"
    "start, or lacks updates later on, the program begins with a transfer to a joiner.\n"
    "\n"
    "Examples:\n"
    "  padr-capture rebuild peer0.pcapng --csv states.csv --svg world.svg\n"
    "  padr-capture rebuild late.pcap --scenario arena --seed 7 --slots 32\n"
    "\n"
    "Exit code: 0 if all hashes agree; 1 if a hash differs, if updates are missing, if nothing could be rebuilt, if a\n"
    "hash was not reached because datagrams have no key, or if a capture is damaged; 2 for a wrong command line, or a\n"
    "capture without a session.";

struct RebuildOptions {
  std::vector<std::string> files;
  std::vector<std::string> keylogs;
  SettingFlags setting;
  std::string json, csv, svg;
};

int run_rebuild(const RebuildOptions& o, const std::vector<std::string>& command) {
  Captures captures(o.files, o.keylogs);
  Bookkeeper books;
  while (const Datagram* d = captures.next()) books.take(*d);
  const int read = warn_unread(captures);
  const SessionLog& session_log = books.choose(o.setting.session());
  if (const std::string why = nothing_to_begin_with(session_log, captures.contents()); !why.empty()) {
    std::fprintf(stderr, "padr-capture: rebuild: %s\n", why.c_str());
    return shell::kExitFailure;
  }
  const Setting setting = o.setting.setting(session_log);

  std::unique_ptr<StatesCsv> csv;
  if (!o.csv.empty()) csv = std::make_unique<StatesCsv>(o.csv);
  WorldPicture picture;
  std::uint64_t last_hash = 0;
  const Rebuilt r = rebuild(session_log, setting, 0, [&](const sync::FoldState& s, std::uint64_t hash) {
    last_hash = hash;
    if (csv) csv->add(s);
    if (!o.svg.empty()) picture.add(s);
  });
  if (csv) csv->close();
  if (!o.svg.empty()) shell::write_text("--svg", o.svg, picture.svg(setting));
  const bool prints = o.json == "-" || o.csv == "-" || o.svg == "-";
  if (!prints) shell::write_text("", "-", rebuilt_text(setting, session_log, r, last_hash));
  if (!o.json.empty()) shell::write_text("--json", o.json, rebuilt_json(setting, session_log, r, last_hash, command));

  bool good = r.got_anywhere() && r.agreeing() == r.hashes.size();
  for (const Stretch& s : r.stretches) good = good && !s.gap;
  if (const std::uint64_t n = many_sealed_unread(captures); n > 0 && r.unreached > 0) {
    std::fprintf(stderr, "padr-capture: rebuild: %llu hashes were not reached, as %llu datagrams could not be read\n",
                 static_cast<unsigned long long>(r.unreached), static_cast<unsigned long long>(n));
    good = false;
  }
  return good ? read : shell::kExitFailure;
}

}  // namespace

Run declare_rebuild(CLI::App& app) {
  const auto o = std::make_shared<RebuildOptions>();
  declare_captures(app, o->files, o->keylogs);
  app.footer(kRebuildFooter);
  o->setting.declare(app);
  app.add_option(
         "--csv", o->csv,
         "Write the confirmed state of every entity at every tick; - for standard output, in\nplace of the text")
      ->type_name("FILE|-");
  app.add_option("--svg", o->svg, "Draw four moments of the world; - for standard output, in place of the text")
      ->type_name("FILE|-");
  app.add_option("--json", o->json, "The result as JSON; - for standard output, in place of the text")
      ->type_name("FILE|-");
  return [o](const std::vector<std::string>& command) { return run_rebuild(*o, command); };
}

}  // namespace padr::capture
