#include "tools/lab/crowd/gang.h"

#include "tools/lab/parallel.h"

namespace padr::lab {

Gang::Gang(int threads) : threads_(static_cast<std::size_t>(threads)), start_(threads), end_(threads) {
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

Gang::~Gang() {
  over_ = true;
  start_.arrive_and_wait();
}

void Gang::run(std::size_t n, const std::function<void(std::size_t)>& job) {
  n_ = n;
  job_ = &job;
  start_.arrive_and_wait();
  work(0);
  end_.arrive_and_wait();
}

void Gang::work(std::size_t self) {
  for (std::size_t i = self; i < n_; i += threads_) (*job_)(i);
}

}  // namespace padr::lab
