#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <new>
#include <utility>

namespace padr::shell {

/// Room for what Asio keeps of handlers while they wait, used again for the next ones. Asio has a cache for that of its
/// own, which kinds of handlers that take turns push out of it, and which has no second place for one that is cancelled
/// and still to be told of it.
class HandlerMemory {
 public:
  HandlerMemory() = default;
  HandlerMemory(const HandlerMemory&) = delete;
  HandlerMemory& operator=(const HandlerMemory&) = delete;

  /// From the heap what does not fit, and when all places are taken.
  void* allocate(std::size_t bytes) {
    for (Place& p : places_)
      if (!p.taken && bytes <= p.room.size()) {
        p.taken = true;
        return p.room.data();
      }
    return ::operator new(bytes);
  }
  void deallocate(void* at) {
    for (Place& p : places_)
      if (at == p.room.data()) {
        p.taken = false;
        return;
      }
    ::operator delete(at);
  }

 private:
  struct Place {
    alignas(std::max_align_t) std::array<std::byte, 256> room{};
    bool taken = false;
  };
  std::array<Place, 4> places_;
};

/// Hands it to Asio: the `allocator_type` of a handler. Shares it: Asio may give it back long after whoever waited has
/// gone.
template <typename T>
class HandlerAllocator {
 public:
  using value_type = T;

  explicit HandlerAllocator(std::shared_ptr<HandlerMemory> memory) : memory_(std::move(memory)) {}
  template <typename U>
  HandlerAllocator(const HandlerAllocator<U>& other) : memory_(other.memory_) {}  // NOLINT(google-explicit-constructor)

  T* allocate(std::size_t n) { return static_cast<T*>(memory_->allocate(n * sizeof(T))); }
  void deallocate(T* at, std::size_t /*n*/) { memory_->deallocate(at); }

  template <typename U>
  bool operator==(const HandlerAllocator<U>& other) const {
    return memory_ == other.memory_;
  }

 private:
  template <typename U>
  friend class HandlerAllocator;
  std::shared_ptr<HandlerMemory> memory_;
};

/// A handler that Asio is to keep in that memory.
template <typename Handler>
class KeptIn {
 public:
  using allocator_type = HandlerAllocator<std::byte>;

  KeptIn(std::shared_ptr<HandlerMemory> memory, Handler handler)
      : allocator_(std::move(memory)), handler_(std::move(handler)) {}

  allocator_type get_allocator() const { return allocator_; }
  template <typename... Args>
  void operator()(Args&&... args) {
    handler_(std::forward<Args>(args)...);
  }

 private:
  allocator_type allocator_;
  Handler handler_;
};

}  // namespace padr::shell
