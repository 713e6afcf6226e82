#pragma once

#include <vector>

#include "common/sync/updates.h"

namespace padr::sync {

/// Bundles that are not needed any more, for others to be copied into: what their bodies took up is there for the next.
/// Orders, which are few, are allocated for each time.
class BundlePool {
 public:
  /// The same as `b`.
  Bundle copy(const Bundle& b);
  void give_back(Bundle&& b);

 private:
  /// Most tell of so many bodies at most.
  static constexpr std::size_t kFew = 4;
  struct Shelf {
    std::vector<Bundle> spare;  ///< with room for all bodies that one from here may tell of
    std::size_t made = 0;       ///< there were never more in use
  };
  static void make_more(Shelf& shelf, std::size_t bodies);

  Shelf few_;
  Shelf many_;
};

}  // namespace padr::sync
