#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace padr::shell {

/// No core dump of this process is written from now on, and no other process of the same user may read its memory or
/// attach a debugger (Linux; elsewhere only the first). Throws std::system_error.
void protect_memory();

/// A short text that is wiped when it ends.
class SecretText {
 public:
  static constexpr std::size_t kMost = 4096;
  /// The whole of a file. `flag` is for the message. Throws UserError, as read_file does; also if it has more than
  /// kMost bytes.
  SecretText(std::string_view flag, const std::string& path);
  /// The value of an environment variable, empty if there is none. It is wiped in the environment and taken out of it.
  /// Before any other thread is there.
  explicit SecretText(const char* variable);
  ~SecretText();
  SecretText(const SecretText&) = delete;
  SecretText& operator=(const SecretText&) = delete;

  std::string_view text() const { return {bytes_.data(), size_}; }

 private:
  std::array<char, kMost + 1> bytes_{};
  std::size_t size_ = 0;
};

}  // namespace padr::shell
