#include "common/trace/flips.h"

namespace padr::trace {

FlipMeter::FlipMeter(int bodies) : held_(static_cast<std::size_t>(bodies)) {}

void FlipMeter::owners(Tick tick, const std::vector<PeerId>& owner) {
  for (std::size_t b = 0; b < held_.size() && b < owner.size(); ++b) {
    Held& held = held_[b];
    if (owner[b] == held.owner) continue;
    if (owner[b] != kNoPeer && held.owner != kNoPeer) {
      const std::uint64_t flip = tick - held.since < kFlipTicks ? 1 : 0;
      HandOvers& of_body = by_body_[static_cast<EntityId>(b)];
      ++of_body.takeovers;
      ++all_.takeovers;
      of_body.flips += flip;
      all_.flips += flip;
    }
    held = {owner[b], tick};
  }
}

}  // namespace padr::trace
