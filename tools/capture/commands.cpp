#include "tools/capture/commands.h"

#include <cstdint>
#include <cstdio>
#include <numeric>

#include "shell/files.h"
#include "shell/run_main.h"
#include "tools/capture/setting.h"
#include "tools/capture/summary.h"

namespace padr::capture {

void declare_captures(CLI::App& app, std::vector<std::string>& files, std::vector<std::string>& keylogs) {
  app.add_option("CAPTURE", files,
                 "pcap or pcapng; - is standard input. Several captures of one session count as one, in the order\n"
                 "of time; a datagram that is in more than one counts once")
      ->required()
      ->type_name("FILE");
  declare_keylogs(app, keylogs);
}

int warn_unread(const Captures& captures) {
  const auto& sealed = captures.contents().sealed;
  const auto all = std::accumulate(sealed.begin(), sealed.end(), std::uint64_t{0});
  // What a command lacks may be in these. A few that are damaged look so, too.
  const auto warn = [&](Keyring::Reading how, const char* what) {
    const std::uint64_t n = sealed[static_cast<std::size_t>(how)];
    if (10 * n > all)
      std::fprintf(stderr, "padr-capture: %llu datagrams %s\n", static_cast<unsigned long long>(n), what);
  };
  warn(Keyring::Reading::kHidden, "are encrypted, and no --keylog has a key for them");
  warn(Keyring::Reading::kWrong,
       "fit no key of their senders: they are damaged or forged, or the --keylog of another peer has that link's keys");
  if (const std::uint64_t back = captures.contents().back; back > 0)
    std::fprintf(stderr,
                 "padr-capture: warning: not in order of time: %llu datagrams are earlier than the one before; "
                 "Wireshark's reordercap sorts a capture\n",
                 static_cast<unsigned long long>(back));
  for (const std::string& t : captures.troubles()) std::fprintf(stderr, "padr-capture: incomplete: %s\n", t.c_str());
  return captures.troubles().empty() ? shell::kExitFine : shell::kExitFailure;
}

Run declare_summary(CLI::App& app) {
  struct Options {
    std::vector<std::string> files;
    std::vector<std::string> keylogs;
    std::string json;
  };
  const auto o = std::make_shared<Options>();
  declare_captures(app, o->files, o->keylogs);
  app.add_option("--json", o->json, "Write everything as JSON; - for standard output, in place of the tables")
      ->type_name("FILE|-");
  return [o](const std::vector<std::string>& command) {
    Captures captures(o->files, o->keylogs);
    Tally tally;
    while (const Datagram* d = captures.next()) tally.take(*d);
    const Source source{o->files, captures.contents(), captures.troubles()};
    if (o->json != "-") shell::write_text("", "-", summary_text(source, tally));
    if (!o->json.empty()) shell::write_text("--json", o->json, summary_json(source, tally, command));
    return warn_unread(captures);
  };
}

}  // namespace padr::capture
