#include "shell/files.h"

#include <cerrno>
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

OutputFile::OutputFile(std::string_view flag, std::string path) : path_(std::move(path)) {
  file_.reset(std::fopen(path_.c_str(), "wb"));
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
  throw std::system_error(errno, std::generic_category(), "cannot write '" + path_ + "'");
}

}  // namespace padr::shell
