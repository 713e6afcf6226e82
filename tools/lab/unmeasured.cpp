#include "tools/lab/unmeasured.h"

#include <cstdio>

#include "tools/lab/simulation.h"

namespace padr::lab {

void warn_of_unmeasured(const std::string& runs, double share, Tick ticks) {
  if (!Simulation::is_little(share, ticks)) return;
  std::fprintf(stderr,
               "padr-lab: warning: %s: inconsistency was measured at the first %.0f %% of ticks only: the others were "
               "not confirmed in time\n",
               runs.c_str(), 100 * share);
}

}  // namespace padr::lab
