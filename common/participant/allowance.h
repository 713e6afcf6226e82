#pragma once

#include <algorithm>
#include <cstddef>

#include "common/model/ids.h"

namespace padr::node {

/// Bytes that may be spent: so many a second, and so many at once.
class Allowance {
 public:
  /// Begins with `left` bytes.
  Allowance(double per_second, double at_once, double left, Micros local)
      : per_second_(per_second), at_once_(at_once), left_(left), since_(local) {}

  void add(std::size_t bytes) { left_ = std::min(at_once_, left_ + static_cast<double>(bytes)); }
  /// Whether there are as many; then they are spent.
  bool take(std::size_t bytes, Micros local) {
    left_ = std::min(at_once_, left_ + static_cast<double>(local - since_) / kMicrosPerSecond * per_second_);
    since_ = local;
    if (left_ < static_cast<double>(bytes)) return false;
    left_ -= static_cast<double>(bytes);
    return true;
  }

 private:
  double per_second_;
  double at_once_;
  double left_;
  Micros since_;
};

}  // namespace padr::node
