#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace padr::shell {

/// The whole of a regular file. `flag` is for the message. Throws UserError, which names the flag, the file and the
/// system's reason, if it cannot be read or is larger than `limit` bytes.
std::string read_file(std::string_view flag, const std::string& path, std::size_t limit = 64U << 20U);

/// Of several recordings those that are not empty, in order; all, if all are, or if one is missing. A peer that has not
/// got into the session leaves an empty one, and the others' need not wait for it. `note`: "FILE: is empty: left out",
/// for each that is.
std::vector<std::string> without_empty(std::vector<std::string> files,
                                       const std::function<void(const std::string&)>& note);

/// Who may read a file that is written. A file for secrets is readable by its owner alone from before anything is in
/// it, whatever it was before, and its path does not end in a symbolic link.
enum class Readers : std::uint8_t {
  kAsUsual,   ///< by the umask, or as it was
  kOwner,     ///< for secrets
  kOwnerNew,  ///< for secrets; the file must not exist yet
};

/// What a file is written with. Text is not written over a file that is no text: that may be a recording, named by
/// mistake.
enum class Content : std::uint8_t { kText, kBinary };

/// A file that is written from its beginning, or standard output for a text to "-". A full disk shows as an exception,
/// at the latest in close().
class OutputFile {
 public:
  /// Creates or empties the file. Throws UserError, which names the flag, if that cannot be done, or if what is no
  /// text, or a secret, is to go to standard output.
  OutputFile(std::string_view flag, std::string path, Readers readers = Readers::kAsUsual,
             Content content = Content::kText);
  /// Throw std::system_error.
  void write(std::span<const std::byte> bytes);
  void write(std::string_view text);
  /// Hands what is buffered to the system.
  void flush();
  void close();

 private:
  struct Close {
    void operator()(std::FILE* f) const {
      if (f != stdout) std::fclose(f);
    }
  };
  [[noreturn]] void fail() const;
  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
};

/// For whoever writes a text to a file only after long work: throws UserError, which names the flag, if OutputFile
/// would refuse the file now. The file stays as it is. "-" and no name at all are right.
void check_writable(std::string_view flag, const std::string& file);

/// Where a text may take the place of what the path names: a symbolic link is followed. Throws UserError, which names
/// the flag, if there is something there that is no text or no file, or the path is "-".
std::string replaceable(std::string_view flag, const std::string& path);

/// The whole text to a file, or to standard output if it is "-". Throws as OutputFile does.
void write_text(std::string_view flag, const std::string& file, std::string_view text);

/// Puts `text` in the place of the file's content at once: whoever is stopped meanwhile, or reads, has the old or the
/// new. Throws UserError, for what replaceable() refuses, too, or std::system_error.
void replace_text(std::string_view flag, const std::string& file, std::string_view text);

/// Does all steps, even after one that has failed, and then throws what the first that failed has thrown.
void do_all(std::initializer_list<std::function<void()>> steps);

}  // namespace padr::shell
