#include "shell/run_main.h"
#include "tools/monitor/options.h"
#include "tools/monitor/program.h"

int main(int argc, char** argv) {
  return padr::shell::run_main("padr-monitor", [&] {
    const auto options = padr::monitor::parse_options(argc, argv);
    return options ? padr::monitor::run(*options) : padr::shell::kExitFine;
  });
}
