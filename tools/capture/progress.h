#pragma once

#include <chrono>
#include <cstdint>

namespace padr::capture {

/// One line on standard error, rewritten twice a second, if that is a terminal and there is much to do.
class Progress {
 public:
  /// `all`: bytes to come; 0: not known.
  explicit Progress(std::uint64_t all);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Cheap enough for every packet.
  void at(std::uint64_t done) {
    if (wanted_ && (++calls_ & 0x3FFFU) == 0) show(done);
  }

 private:
  void show(std::uint64_t done);

  std::uint64_t all_;
  bool wanted_;
  bool shown_ = false;
  std::uint64_t calls_ = 0;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace padr::capture
