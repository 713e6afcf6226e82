#include "tools/monitor/options.h"
#include "tools/monitor/program.h"
#include "tools/support/run_main.h"

int main(int argc, char** argv) {
  return padr::support::run_main("padr-monitor", [&] {
    const auto options = padr::monitor::parse_options(argc, argv);
    return options ? padr::monitor::run(*options) : padr::support::kExitFine;
  });
}
