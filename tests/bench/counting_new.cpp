// Puts itself in place of every `new` of the program that it is linked into.
#include <cstdlib>
#include <new>

#include "tests/bench/allocations.h"

namespace {

void* counted(std::size_t bytes) {
  padr::bench::count_allocation();
  if (void* p = std::malloc(bytes == 0 ? 1 : bytes)) return p;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t bytes) {
  return counted(bytes);
}
void* operator new[](std::size_t bytes) {
  return counted(bytes);
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
