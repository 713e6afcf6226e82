#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/channel/parcel.h"

namespace padr::node {

/// Datagrams for the shell to send, in order. Their memory is used again: it is as much as was waiting at most.
class Outbox {
 public:
  /// Copies them.
  void add(const Endpoint& to, PeerId state_to, std::span<const std::byte> bytes) {
    if (taken_) count_ = 0;
    taken_ = false;
    if (count_ == parcels_.size()) parcels_.emplace_back();
    Parcel& p = parcels_[count_++];
    p.to = to;
    p.state_to = state_to;
    p.bytes.assign(bytes.begin(), bytes.end());
  }
  void add(std::span<const Parcel> parcels) {
    for (const Parcel& p : parcels) add(p.to, p.state_to, p.bytes);
  }
  /// All since the last time; as long as nothing is added.
  std::span<const Parcel> take() {
    if (taken_) count_ = 0;
    taken_ = true;
    return std::span<const Parcel>(parcels_).first(count_);
  }

 private:
  std::vector<Parcel> parcels_;
  std::size_t count_ = 0;
  bool taken_ = false;  ///< the first `count_` have been taken
};

}  // namespace padr::node
