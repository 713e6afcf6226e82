#pragma once

#include <barrier>
#include <cstddef>
#include <functional>
#include <thread>
#include <vector>

namespace padr::lab {

/// Threads that do the same thing again and again, each time to other ones of n items, and wait for one another after
/// each time. Which thread does which items is always the same.
class WorkerGroup {
 public:
  /// `threads` >= 1, the caller's included.
  explicit WorkerGroup(int threads);
  ~WorkerGroup();
  WorkerGroup(const WorkerGroup&) = delete;
  WorkerGroup& operator=(const WorkerGroup&) = delete;

  /// Calls job(0) .. job(n - 1), and returns when all have ended. Jobs must not touch what others change, nor throw.
  void run(std::size_t n, const std::function<void(std::size_t)>& job);

 private:
  void work(std::size_t self);

  std::size_t threads_;
  std::size_t n_ = 0;
  const std::function<void(std::size_t)>* job_ = nullptr;
  bool over_ = false;
  std::barrier<> start_;
  std::barrier<> end_;
  std::vector<std::jthread> others_;  ///< last: they use the rest
};

}  // namespace padr::lab
