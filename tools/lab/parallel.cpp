#include "tools/lab/parallel.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>
#include <mutex>
#include <thread>

#include "common/world/fingerprint.h"

namespace padr::lab {
namespace {

/// A line on standard error, drawn over again; none if that is not a terminal or if all is over in a second.
class Progress {
 public:
  Progress(std::size_t all, const ParallelOptions& o)
      : all_(all), what_(o.what), shown_(!o.quiet && isatty(STDERR_FILENO) != 0) {}
  ~Progress() {
    if (drawn_) std::fputs("\r\033[K", stderr);
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void another() {
    const std::lock_guard lock(mutex_);
    ++done_;
    const double spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    if (!shown_ || spent < 1 || done_ == all_) return;
    const double left = spent * static_cast<double>(all_ - done_) / static_cast<double>(done_);
    std::fprintf(stderr, "\r%zu of %zu %s, %.0f s left \033[K", done_, all_, what_.c_str(), left);
    drawn_ = true;
  }

 private:
  std::mutex mutex_;
  std::size_t all_;
  std::size_t done_ = 0;
  std::string what_;
  bool shown_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::size_t threads_of(const ParallelOptions& o, std::size_t n) {
  const std::size_t processors = std::max(1U, std::thread::hardware_concurrency());
  return std::min(n, o.threads > 0 ? static_cast<std::size_t>(o.threads) : processors);
}

}  // namespace

void before_threads() {
  world::physics_fingerprint();
}

void run_parallel(std::size_t n, const std::function<void(std::size_t)>& job, const ParallelOptions& options) {
  before_threads();
  Progress progress(n, options);
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  std::vector<std::exception_ptr> errors(n);
  const auto work = [&] {
    while (!failed) {
      const std::size_t i = next++;
      if (i >= n) return;
      try {
        job(i);
      } catch (...) {
        errors[i] = std::current_exception();
        failed = true;
      }
      progress.another();
    }
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 1; t < threads_of(options, n); ++t) threads.emplace_back(work);
    work();
  }
  for (const std::exception_ptr& e : errors)
    if (e) std::rethrow_exception(e);
}

}  // namespace padr::lab
