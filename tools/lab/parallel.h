#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace padr::lab {

struct ParallelOptions {
  int threads = 0;            ///< at once; 0: as many as there are processors
  std::string what = "runs";  ///< for the line that says how far it is
  bool quiet = false;         ///< no such line, not even on a terminal
};

/// To be called before there are threads that step worlds: Box2D fills a table of its own at its first contact and does
/// not guard it.
void before_threads();

/// Calls job(0) .. job(n - 1), each once, several at a time, and returns when all have ended. Jobs must not touch what
/// others change. On a terminal a line on standard error says how many are done and how long the rest may take. If
/// jobs throw, no further ones are begun, and the exception of the lowest number is thrown here.
void run_parallel(std::size_t n, const std::function<void(std::size_t)>& job, const ParallelOptions& options = {});

/// The same for jobs with results, which come in the order of the jobs whatever the order they ended in.
template <typename Result>
std::vector<Result> parallel_results(std::size_t n, const std::function<Result(std::size_t)>& job,
                                     const ParallelOptions& options = {}) {
  std::vector<std::optional<Result>> slots(n);
  run_parallel(
      n, [&](std::size_t i) { slots[i].emplace(job(i)); }, options);
  std::vector<Result> results;
  results.reserve(n);
  for (std::optional<Result>& s : slots) results.push_back(std::move(*s));
  return results;
}

}  // namespace padr::lab
