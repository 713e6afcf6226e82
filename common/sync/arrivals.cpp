#include "common/sync/arrivals.h"

#include <limits>

namespace padr::sync {

Arrivals::Arrivals(int slots, int bodies)
    : newest_avatar_(static_cast<std::size_t>(slots), -1),
      newest_body_(static_cast<std::size_t>(slots), std::vector<Tick>(static_cast<std::size_t>(bodies), -1)) {}

void Arrivals::take_back(PeerId peer, std::uint32_t from) {
  std::erase_if(waiting_, [&](const Bundle& b) { return b.peer == peer && b.index >= from; });
}

std::uint64_t Arrivals::apply_to(Fold& fold) {
  std::uint64_t refused = 0;
  for (Bundle& b : waiting_) {
    keep_newest(b);
    b.tick = fold.tick();
    refused += static_cast<std::uint64_t>(fold.apply(b));
  }
  waiting_.clear();
  return refused;
}

// Takes out of it what is older than what has been here.
void Arrivals::keep_newest(Bundle& b) {
  if (b.leave) newest_avatar_[b.peer] = std::numeric_limits<Tick>::max();
  if (b.admission) {
    newest_avatar_[b.admission->slot] = -1;
    newest_body_[b.admission->slot].assign(newest_body_[b.admission->slot].size(), -1);
  }
  if (b.avatar && b.tick <= newest_avatar_[b.peer] && !b.leave) b.avatar.reset();
  if (b.avatar) newest_avatar_[b.peer] = b.tick;
  std::vector<Tick>& newest = newest_body_[b.peer];
  std::erase_if(b.bodies, [&](const BodyUpdate& u) { return b.tick <= newest[u.body]; });
  for (const BodyUpdate& u : b.bodies) newest[u.body] = b.tick;
}

}  // namespace padr::sync
