#include "common/capture/byte_queue.h"

#include <algorithm>
#include <cassert>

namespace padr::capture {
namespace {

constexpr std::size_t kBuffer = 1U << 20U;

}  // namespace

ByteQueue::ByteQueue(ByteSource source) : source_(std::move(source)), buffer_(kBuffer) {}

ByteView ByteQueue::peek(std::size_t n) {
  if (end_ - begin_ < n && buffer_.size() - begin_ < n) {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
              buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
    end_ -= begin_;
    begin_ = 0;
    if (buffer_.size() < n) buffer_.resize(n);
  }
  while (end_ - begin_ < n) {
    const std::size_t got = source_(std::span(buffer_).subspan(end_));
    if (got == 0) break;
    end_ += got;
  }
  return ByteView(buffer_).subspan(begin_, std::min(n, end_ - begin_));
}

void ByteQueue::take(std::size_t n) {
  assert(n <= end_ - begin_);
  begin_ += n;
  offset_ += n;
}

}  // namespace padr::capture
