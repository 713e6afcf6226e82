#include <string_view>

#include "common/model/user_error.h"
#include "common/wire/secret.h"
#include "peer/crowd_loop.h"
#include "peer/event_loop.h"
#include "peer/fingerprint_command.h"
#include "peer/log.h"
#include "peer/options.h"
#include "peer/session_key.h"
#include "shell/clock.h"
#include "shell/run_main.h"
#include "shell/scenario_flags.h"

int main(int argc, char** argv) {
  const padr::shell::Clock clock;
  return padr::shell::run_main("padr-peer", [&] {
    if (argc > 1 && std::string_view(argv[1]) == "keygen") return padr::peer::keygen(argc, argv);
    if (argc > 1 && std::string_view(argv[1]) == "fingerprint") return padr::peer::fingerprint_command(argc, argv);
    padr::wire::choose_fast_code();
    const auto options = padr::peer::parse_options(argc, argv);
    if (!options) return padr::shell::kExitFine;
    padr::peer::Log log(options->log_level, options->log_levels);
    for (const auto& line : options->warnings) log.session->warn("{}", line);
    const padr::Scene& ground = options->crowd ? options->crowd->ground : options->scenario.scene;
    if (const auto notes = padr::shell::notes_on_input(options->input, ground)) {
      log.play->info("{}", notes->summary);
      for (const auto& line : notes->warnings) log.play->warn("{}", line);
    }
    if (options->crowd) return padr::peer::CrowdLoop(*options, log, clock).run();
    return padr::peer::EventLoop(*options, log, clock).run();
  });
}
