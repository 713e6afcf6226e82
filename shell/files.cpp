#include "shell/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <exception>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "common/model/user_error.h"

namespace padr::shell {
namespace {

std::string system_reason() {
  return std::generic_category().message(errno);
}

}  // namespace

std::string read_file(std::string_view flag, const std::string& path, std::size_t limit) {
  const auto bad = [&](const std::string& why) {
    return UserError(std::string(flag) + ": cannot read '" + path + "': " + why);
  };
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw bad("it is a directory");
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) throw bad(system_reason());
  std::string text;
  std::string chunk(1U << 16U, '\0');
  while (in) {
    in.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
    text.append(chunk, 0, static_cast<std::size_t>(in.gcount()));
    if (text.size() > limit) throw bad("it is larger than " + std::to_string(limit) + " bytes");
  }
  if (in.bad()) throw bad(system_reason());
  return text;
}

std::vector<std::string> without_empty(std::vector<std::string> files,
                                       const std::function<void(const std::string&)>& note) {
  const auto is_empty = [](const std::string& file) {
    std::error_code error;
    return std::filesystem::is_regular_file(file, error) && std::filesystem::file_size(file, error) == 0;
  };
  const auto exists = [](const std::string& file) {
    std::error_code error;
    return std::filesystem::exists(file, error);
  };
  const bool are_there = std::all_of(files.begin(), files.end(), exists);
  if (!are_there || std::all_of(files.begin(), files.end(), is_empty)) return files;
  for (const std::string& f : files)
    if (is_empty(f)) note(f + ": is empty: left out");
  std::erase_if(files, is_empty);
  return files;
}

namespace {

// All by one descriptor: what a path names may change between two calls.
std::FILE* open_for_owner(const std::string& path, bool new_file) {
  constexpr mode_t kOwner = S_IRUSR | S_IWUSR;
  const int how = O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW | (new_file ? O_EXCL : 0);
  const int fd = ::open(path.c_str(), how, kOwner);
  if (fd < 0) return nullptr;
  struct stat s {};
  const bool fine =
      ::fstat(fd, &s) == 0 && (!S_ISREG(s.st_mode) || (::fchmod(fd, kOwner) == 0 && ::ftruncate(fd, 0) == 0));
  std::FILE* const file = fine ? ::fdopen(fd, "wb") : nullptr;
  if (file != nullptr) return file;
  const int why = errno;
  ::close(fd);
  errno = why;
  return nullptr;
}

bool is_binary(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  std::array<char, 64> head{};
  std::ifstream in(path, std::ios::binary);
  in.read(head.data(), head.size());
  return std::any_of(head.begin(), head.begin() + in.gcount(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return (byte < ' ' && c != '\n' && c != '\r' && c != '\t') || byte == 0x7F;
  });
}

void refuse_binary(std::string_view flag, const std::string& path) {
  if (is_binary(path))
    throw UserError(std::string(flag) + ": '" + path +
                    "' is no text, perhaps a recording, and is not overwritten; name another file");
}

void refuse_standard_output(std::string_view flag, const std::string& path) {
  if (path == "-") throw UserError(std::string(flag) + ": this cannot be printed; name a file in place of -");
}

}  // namespace

void check_writable(std::string_view flag, const std::string& file) {
  std::error_code error;
  const auto kind = std::filesystem::status(file, error).type();
  // To open a pipe would wait for whoever reads it.
  const bool opens = kind == std::filesystem::file_type::regular || kind == std::filesystem::file_type::directory;
  const bool is_new = kind == std::filesystem::file_type::not_found;
  if (file.empty() || file == "-" || !(opens || is_new)) return;
  refuse_binary(flag, file);
  constexpr mode_t kAsUsual = S_IRUSR | S_IWUSR | S_IRGRP | S_IWGRP | S_IROTH | S_IWOTH;
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, kAsUsual);
  if (fd < 0) throw UserError(std::string(flag) + ": cannot write '" + file + "': " + system_reason());
  ::close(fd);
  if (is_new) std::filesystem::remove(std::filesystem::weakly_canonical(file, error), error);
}

std::string replaceable(std::string_view flag, const std::string& path) {
  constexpr int kMostLinks = 40;  // as Linux follows
  refuse_standard_output(flag, path);
  refuse_binary(flag, path);
  std::error_code error;
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error))
    throw UserError(std::string(flag) + ": '" + path +
                    "' is no regular file, and cannot be replaced; name another one");
  // A link may lead to what is not there yet.
  std::filesystem::path place = path;
  for (int links = 0; links < kMostLinks && std::filesystem::is_symlink(place, error); ++links)
    place = place.parent_path() / std::filesystem::read_symlink(place, error);
  const std::filesystem::path whole = std::filesystem::weakly_canonical(place, error);
  return error ? path : whole.string();
}

OutputFile::OutputFile(std::string_view flag, std::string path, Readers readers, Content content)
    : path_(std::move(path)) {
  if (readers == Readers::kAsUsual && content == Content::kText && path_ == "-") {
    file_.reset(stdout);
    return;
  }
  refuse_standard_output(flag, path_);
  if (content == Content::kText) refuse_binary(flag, path_);
  file_.reset(readers == Readers::kAsUsual ? std::fopen(path_.c_str(), "wb")
                                           : open_for_owner(path_, readers == Readers::kOwnerNew));
  if (!file_) throw UserError(std::string(flag) + ": cannot write '" + path_ + "': " + system_reason());
}

void OutputFile::write(std::span<const std::byte> bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) fail();
}

void OutputFile::write(std::string_view text) {
  write(std::as_bytes(std::span(text)));
}

void OutputFile::flush() {
  if (std::fflush(file_.get()) != 0) fail();
}

void OutputFile::close() {
  if (!file_) return;
  flush();
  file_.reset();
}

void OutputFile::fail() const {
  throw std::system_error(errno, std::generic_category(),
                          path_ == "-" ? "cannot write to standard output" : "cannot write '" + path_ + "'");
}

void do_all(std::initializer_list<std::function<void()>> steps) {
  std::exception_ptr first;
  for (const auto& step : steps) {
    try {
      step();
    } catch (...) {
      if (!first) first = std::current_exception();
    }
  }
  if (first) std::rethrow_exception(first);
}

void write_text(std::string_view flag, const std::string& file, std::string_view text) {
  OutputFile out(flag, file);
  out.write(text);
  out.close();
}

void replace_text(std::string_view flag, const std::string& file, std::string_view text) {
  const std::string place = replaceable(flag, file);
  const std::filesystem::path folder = std::filesystem::path(place).parent_path();
  std::error_code error;
  if (!folder.empty() && !std::filesystem::is_directory(folder, error))
    throw UserError(std::string(flag) + ": cannot write '" + file + "': there is no folder " + folder.string());
  const std::string part = place + ".part";
  OutputFile out(flag, part);
  try {
    out.write(text);
    out.close();
    std::filesystem::rename(part, place);
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    throw;
  }
}

}  // namespace padr::shell
