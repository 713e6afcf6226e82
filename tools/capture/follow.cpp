#include <chrono>
#include <cstdio>
#include <thread>

#include "common/capture/frame_reader.h"
#include "common/model/user_error.h"
#include "shell/command_line.h"
#include "tools/capture/commands.h"
#include "tools/capture/sentence.h"
#include "tools/capture/setting.h"

namespace padr::capture {
namespace {

using Steady = std::chrono::steady_clock;

constexpr const char* kFollowFooter =
    "Examples:\n"
    "  padr-capture follow peer0.pcapng\n"
    "  tcpdump -U -i any -w - udp | padr-capture follow -\n"
    "\n"
    "The program reads standard input to its end. It watches a file until you stop the program, or until --idle ends\n"
    "it. Exit code: 0, or 1 if the capture is damaged.";

struct FollowOptions {
  std::string file;
  std::vector<std::string> keylogs;
  bool json = false;
  double idle = 0;
};

void say(Recorder& recorder, const Datagram& d, bool json) {
  const Record r = recorder.record(d);
  const std::string line = (json ? r.json() : sentence(r)) + "\n";
  std::fwrite(line.data(), 1, line.size(), stdout);
}

int run_follow(const FollowOptions& o) {
  constexpr auto kLook = std::chrono::milliseconds(50);
  if (o.file == "-" && o.idle > 0)
    throw UserError("--idle does not go with standard input, which ends by itself; leave it out, or name a file");
  // One file, which is asked again at its end: a pipe has none before the last writer is gone.
  Captures captures({o.file}, o.keylogs);
  Recorder recorder;
  auto heard = Steady::now();
  while (true) {
    while (const Datagram* d = captures.next()) {
      say(recorder, *d, o.json);
      heard = Steady::now();
    }
    if (std::fflush(stdout) != 0 || o.file == "-" || captures.damaged()) break;
    if (o.idle > 0 && Steady::now() - heard > std::chrono::duration<double>(o.idle)) break;
    std::this_thread::sleep_for(kLook);
    captures.look_again();
  }
  return warn_unread(captures);
}

}  // namespace

Run declare_follow(CLI::App& app) {
  const auto o = std::make_shared<FollowOptions>();
  app.footer(kFollowFooter);
  app.add_option("CAPTURE", o->file, "pcap or pcapng that is being written; - is standard input")
      ->required()
      ->type_name("FILE");
  declare_keylogs(app, o->keylogs);
  app.add_flag("--json", o->json, "Datagrams as padr-capture export --json has them");
  app.add_option("--idle", o->idle, "Stop after S seconds without a datagram, for a file; 0: never")
      ->type_name("S")
      ->check(shell::between(0.0, 86400.0, "seconds"))
      ->capture_default_str();
  return [o](const std::vector<std::string>&) { return run_follow(*o); };
}

}  // namespace padr::capture
