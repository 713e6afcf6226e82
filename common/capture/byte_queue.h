#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/capture/byte_order.h"

namespace padr::capture {

/// Fills what it is given from its beginning and says how many bytes that were; 0: there is nothing more for now.
using ByteSource = std::function<std::size_t(std::span<std::byte>)>;

/// Bytes of a source that are read but not yet used up, contiguous. Memory is bounded by the most that is asked for.
class ByteQueue {
 public:
  explicit ByteQueue(ByteSource source);

  /// The next `n` bytes, or fewer if the source has no more for now. Valid until the next call of either.
  ByteView peek(std::size_t n);
  /// Uses up `n` bytes that have been peeked at.
  void take(std::size_t n);
  /// Bytes used up so far.
  std::uint64_t offset() const { return offset_; }

 private:
  ByteSource source_;
  std::vector<std::byte> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint64_t offset_ = 0;
};

}  // namespace padr::capture
