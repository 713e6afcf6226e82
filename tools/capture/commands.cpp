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

namespace {

/// So many datagrams were read this way, if that is more than one in ten.
std::uint64_t many_sealed(const Captures& captures, Keyring::Reading how) {
  const auto& sealed = captures.contents().sealed;
  const auto all = std::accumulate(sealed.begin(), sealed.end(), std::uint64_t{0});
  const std::uint64_t n = sealed[static_cast<std::size_t>(how)];
  return 10 * n > all ? n : 0;
}

void warn_packets(const Captures& captures) {
  const Contents& c = captures.contents();
  std::string names;
  for (const std::string& name : captures.names()) names += (names.empty() ? "" : ", ") + name;
  const auto warn = [&](std::uint64_t n, const char* what) {
    if (n > 0)
      std::fprintf(stderr, "padr-capture: %s: %llu of %llu packets are %s\n", names.c_str(),
                   static_cast<unsigned long long>(n), static_cast<unsigned long long>(c.packets), what);
  };
  const auto of = [&c](Content k) { return c.of[static_cast<std::size_t>(k)]; };
  warn(of(Content::kCutUdp) + of(Content::kCutHeaders), "cut off by the capture (snaplen); capture with -s 0");
  warn(of(Content::kUnknownLink), "of a link type that is not understood");
}

}  // namespace

std::uint64_t many_sealed_unread(const Captures& captures) {
  const Contents& c = captures.contents();
  const std::uint64_t carried = 10 * c.carried_unread > c.carried ? c.carried_unread : 0;
  return many_sealed(captures, Keyring::Reading::kHidden) + many_sealed(captures, Keyring::Reading::kWrong) + carried;
}

int warn_unread(const Captures& captures) {
  warn_packets(captures);
  const auto warn = [&](Keyring::Reading how, const char* what) {
    if (const std::uint64_t n = many_sealed(captures, how); n > 0)
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
