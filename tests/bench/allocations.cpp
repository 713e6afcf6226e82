#include "tests/bench/allocations.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace padr::bench {
namespace {

std::atomic<std::uint64_t> count{0};

void* counted(std::size_t bytes) {
  count.fetch_add(1, std::memory_order_relaxed);
  if (void* p = std::malloc(bytes == 0 ? 1 : bytes)) return p;
  throw std::bad_alloc();
}

}  // namespace

std::uint64_t allocations() {
  return count.load(std::memory_order_relaxed);
}

}  // namespace padr::bench

void* operator new(std::size_t bytes) {
  return padr::bench::counted(bytes);
}
void* operator new[](std::size_t bytes) {
  return padr::bench::counted(bytes);
}
void operator delete(void* p) noexcept {
  std::free(p);
}
void operator delete[](void* p) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t /*bytes*/) noexcept {
  std::free(p);
}
void operator delete[](void* p, std::size_t /*bytes*/) noexcept {
  std::free(p);
}
