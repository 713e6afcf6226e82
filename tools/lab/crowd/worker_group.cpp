#include "tools/lab/crowd/worker_group.h"

#include "tools/lab/parallel.h"

namespace padr::lab {

WorkerGroup::WorkerGroup(int threads) : threads_(static_cast<std::size_t>(threads)), start_(threads), end_(threads) {
  before_threads();
  for (std::size_t t = 1; t < threads_; ++t)
    others_.emplace_back([this, t] {
      for (;;) {
        start_.arrive_and_wait();
        if (over_) return;
        work(t);
        end_.arrive_and_wait();
      }
    });
}

WorkerGroup::~WorkerGroup() {
  over_ = true;
  start_.arrive_and_wait();
}

void WorkerGroup::run(std::size_t n, const std::function<void(std::size_t)>& job) {
  n_ = n;
  job_ = &job;
  start_.arrive_and_wait();
  work(0);
  end_.arrive_and_wait();
}

void WorkerGroup::work(std::size_t self) {
  for (std::size_t i = self; i < n_; i += threads_) (*job_)(i);
}

}  // namespace padr::lab
