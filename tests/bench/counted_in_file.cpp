// For padr-peer-counted: allocations are counted in the first eight bytes of the file that PADR_ALLOCATIONS names,
// where whoever runs it can read them at any time. Without it they are counted nowhere.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace padr::bench {
namespace {

using Count = std::atomic<std::uint64_t>;
static_assert(sizeof(Count) == 8 && Count::is_always_lock_free);

Count nowhere{0};
Count* count = &nowhere;

// Allocations of before this runs, as the program starts, are lost, and nobody wants them.
const bool opened = [] {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): before any thread is there, and nobody sets variables
  const char* file = std::getenv("PADR_ALLOCATIONS");
  const int fd = file == nullptr ? -1 : open(file, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0 || ftruncate(fd, sizeof(Count)) != 0) return false;
  void* page = mmap(nullptr, sizeof(Count), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  close(fd);
  if (page == MAP_FAILED) return false;
  count = new (page) Count(0);
  return true;
}();

void* counted(std::size_t bytes) {
  count->fetch_add(1, std::memory_order_relaxed);
  if (void* p = std::malloc(bytes == 0 ? 1 : bytes)) return p;
  throw std::bad_alloc();
}

}  // namespace
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
