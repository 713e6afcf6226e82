#include "tools/lab/measure/processor_time.h"

#include <ctime>

#include "common/world/avatar_control.h"

namespace padr::lab {
namespace {

/// s, of this thread alone: other runs beside it do not count.
double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

}  // namespace

ProcessorTime::ProcessorTime(const Scene& scene, int peers) : peers_(peers), bare_(scene, peers) {
  for (PeerId p = 0; p < peers; ++p) {
    bare_.set_present(bare_.avatar(p), true);
    bare_.set_free(p, true);
  }
}

void ProcessorTime::begin() {
  runs_ = true;
  begun_s_ = thread_seconds();
}

void ProcessorTime::end() {
  peers_s_ += thread_seconds() - begun_s_;
  runs_ = false;
}

void ProcessorTime::step_bare(std::span<const Vec2> hands) {
  const double begun = thread_seconds();
  for (PeerId p = 0; p < hands.size(); ++p) world::drive_avatar(bare_, p, hands[p]);
  bare_.step();
  bare_s_ += thread_seconds() - begun;
}

}  // namespace padr::lab
