#include "tools/capture/progress.h"

#include <unistd.h>

#include <cstdio>

namespace padr::capture {
namespace {

using namespace std::chrono_literals;

constexpr auto kPace = 500ms;
constexpr double kMega = 1.0e6;

}  // namespace

Progress::Progress(std::uint64_t all)
    : all_(all), wanted_(isatty(STDERR_FILENO) == 1), next_(std::chrono::steady_clock::now() + kPace) {}

Progress::~Progress() {
  if (shown_) std::fputs("\r\033[K", stderr);
}

void Progress::show(std::uint64_t done) {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + kPace;
  shown_ = true;
  if (all_ > 0) {
    std::fprintf(stderr, "\r%3.0f %% of %.0f MB", 100.0 * static_cast<double>(done) / static_cast<double>(all_),
                 static_cast<double>(all_) / kMega);
  } else {
    std::fprintf(stderr, "\r%.0f MB", static_cast<double>(done) / kMega);
  }
}

}  // namespace padr::capture
