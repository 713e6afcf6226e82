#pragma once

#include <cassert>
#include <cstddef>
#include <utility>
#include <vector>

namespace padr {

/// A queue in one piece of memory, which grows to what it once had to hold and is kept: unlike a std::deque's, its
/// turnover allocates nothing.
template <typename T>
class Ring {
 public:
  Ring() = default;
  /// With room for so many.
  explicit Ring(std::size_t room) : places_(room) {}

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return places_[(head_ + i) % places_.size()]; }
  const T& operator[](std::size_t i) const { return places_[(head_ + i) % places_.size()]; }
  T& front() { return (*this)[0]; }
  const T& front() const { return (*this)[0]; }
  T& back() { return (*this)[size_ - 1]; }
  const T& back() const { return (*this)[size_ - 1]; }

  void push_back(T v) {
    if (size_ == places_.size()) grow();
    ++size_;
    back() = std::move(v);
  }
  /// Not of an empty one.
  T pop_front() {
    assert(size_ > 0);
    T v = std::move(front());
    head_ = (head_ + 1) % places_.size();
    --size_;
    return v;
  }

 private:
  void grow() {
    std::vector<T> larger;
    larger.reserve(2 * size_ + 4);
    for (std::size_t i = 0; i < size_; ++i) larger.push_back(std::move((*this)[i]));
    larger.resize(larger.capacity());
    places_ = std::move(larger);
    head_ = 0;
  }

  std::vector<T> places_;
  std::size_t head_ = 0;
  std::size_t size_ = 0;
};

}  // namespace padr
