#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "shell/files.h"

namespace padr::peer {

/// A file that a thread of its own writes, so that a slow disk holds nobody up. What has been appended is handed to
/// the system within `interval`.
class BackgroundFile {
 public:
  /// Opens the file: throws UserError, which names the flag, if that cannot be. `most` bytes may wait to be written.
  BackgroundFile(std::string_view flag, const std::string& path, std::chrono::milliseconds interval, std::size_t most);
  ~BackgroundFile();
  BackgroundFile(const BackgroundFile&) = delete;
  BackgroundFile& operator=(const BackgroundFile&) = delete;

  /// All of it or, if too much waits already or something could not be written, nothing: then false.
  bool append(std::span<const std::byte> bytes);
  /// Why something could not be written; then nothing more is. Empty: all could.
  std::string failure();
  /// Writes what is left. Throws std::system_error if anything could not be written.
  void close();

 private:
  void write_on();
  /// Once all that waits is written.
  void end_thread();

  shell::OutputFile file_;  ///< the thread's alone, while it runs
  std::chrono::milliseconds interval_;
  std::mutex mutex_;  ///< of what follows
  std::condition_variable wake_;
  std::vector<std::byte> waiting_;
  std::size_t room_;
  bool closing_ = false;
  std::string failure_;         ///< if it is not empty, nothing more is written
  std::exception_ptr trouble_;  ///< the thread's alone, while it runs
  std::thread thread_;          ///< last: runs on all of the above
};

}  // namespace padr::peer
