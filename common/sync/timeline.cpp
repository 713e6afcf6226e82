#include "common/sync/timeline.h"

#include <algorithm>
#include <bit>

namespace padr::sync {

void SnapshotRoom::make(world::Snapshot& s) const {
  s.contacts.reserve(most_contacts_);
  s.parted.reserve(most_parted_);
}

void SnapshotRoom::save(const Fold& fold, FoldState& out) {
  make(out.world);
  fold.save(out);
  most_contacts_ = std::max(most_contacts_, std::bit_ceil(out.world.contacts.size()));
  most_parted_ = std::max(most_parted_, std::bit_ceil(out.world.parted.size()));
}

}  // namespace padr::sync
