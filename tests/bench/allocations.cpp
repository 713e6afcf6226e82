#include "tests/bench/allocations.h"

#include <atomic>

namespace padr::bench {
namespace {

std::atomic<std::uint64_t> count{0};

}  // namespace

void count_allocation() {
  count.fetch_add(1, std::memory_order_relaxed);
}

std::uint64_t allocations() {
  return count.load(std::memory_order_relaxed);
}

}  // namespace padr::bench
