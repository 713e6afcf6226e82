#include "common/sync/bundle_pool.h"

#include <algorithm>
#include <utility>

namespace padr::sync {

// By halves, so that a new record in use is not always one of what has been made.
void BundlePool::make_more(Shelf& shelf, std::size_t bodies) {
  constexpr std::size_t kLeast = 4;
  const std::size_t more = std::max(kLeast, shelf.made / 2);
  shelf.made += more;
  shelf.spare.reserve(shelf.made);
  for (std::size_t i = 0; i < more; ++i) shelf.spare.emplace_back().bodies.reserve(bodies);
}

Bundle BundlePool::copy(const Bundle& b) {
  const bool few = b.bodies.size() <= kFew;
  Shelf& shelf = few ? few_ : many_;
  if (shelf.spare.empty()) make_more(shelf, few ? kFew : std::max(kMaxBodiesPerBundle, b.bodies.size()));
  Bundle out = std::move(shelf.spare.back());
  shelf.spare.pop_back();
  out = b;
  return out;
}

void BundlePool::give_back(Bundle&& b) {
  if (b.bodies.capacity() < kFew) return;  // not from here
  Shelf& shelf = b.bodies.capacity() < kMaxBodiesPerBundle ? few_ : many_;
  if (shelf.spare.size() < shelf.made) shelf.spare.push_back(std::move(b));
}

}  // namespace padr::sync
