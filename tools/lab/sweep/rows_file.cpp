#include "tools/lab/sweep/rows_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <optional>
#include <system_error>

#include "common/model/user_error.h"
#include "shell/files.h"
#include "shell/text.h"

namespace padr::lab::sweep {
namespace {

// A row is about half a kilobyte: millions of them.
constexpr std::size_t kMostBytes = std::size_t{4} << 30U;

std::optional<std::size_t> number_of(std::string_view text) {
  std::size_t v = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return v;
}

std::optional<StoredRow> row_of(std::string_view line, const std::vector<std::string>& f, std::size_t fields) {
  if (f.size() != fields) return std::nullopt;
  const auto run = number_of(f[1]);
  const auto of = number_of(f[2]);
  if (f[0].empty() || !run || !of || *run >= *of) return std::nullopt;
  return StoredRow{f[0], *run, *of, std::string(line), 0};
}

/// The columns behind the seed are measures, but for a name and the words of a setting.
void check_measures(const std::vector<std::string>& names, const std::vector<std::string>& fields,
                    const std::string& where) {
  const auto seed = static_cast<std::size_t>(std::find(names.begin(), names.end(), "seed") - names.begin());
  for (std::size_t c = seed + 1; c < names.size(); ++c) {
    if (names[c] == "confirmed_hash" || names[c] == "setting") continue;
    double v = 0;
    const char* const last = fields[c].data() + fields[c].size();
    const auto [end, error] = std::from_chars(fields[c].data(), last, v);
    if (error != std::errc() || end != last)
      throw UserError(where + ": '" + fields[c] + "' in column " + names[c] + " is no number");
  }
}

}  // namespace

StoredRows read_rows(std::string_view flag, const std::string& file) {
  const std::string text = shell::read_file(flag, file, kMostBytes);
  StoredRows stored;
  std::size_t line = 0;
  std::vector<std::string> names;
  std::size_t from = 0;
  for (std::size_t to = text.find('\n'); to != std::string::npos; to = text.find('\n', from)) {
    const std::string_view content = std::string_view(text).substr(from, to - from);
    from = to + 1;
    if (++line == 1) {
      stored.heading = content;
      names = fields_of(content);
      if (!content.starts_with("grid,run,of,"))
        throw UserError(std::string(flag) + ": " + file +
                        ":1: is not the heading of a sweep, which begins grid,run,of");
      continue;
    }
    const std::string where = std::string(flag) + ": " + file + ":" + std::to_string(line);
    const std::vector<std::string> fields = fields_of(content);
    auto row = row_of(content, fields, names.size());
    if (!row) throw UserError(where + ": is not a row of a sweep");
    check_measures(names, fields, where);
    row->line = line;
    stored.rows.push_back(std::move(*row));
  }
  stored.rest = text.substr(from);
  return stored;
}

std::vector<std::string> fields_of(std::string_view line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') {
      // Two in a row stand for one.
      if (quoted && i + 1 < line.size() && line[i + 1] == '"')
        fields.back() += line[i++];
      else
        quoted = !quoted;
    } else if (line[i] == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += line[i];
    }
  }
  return fields;
}

std::string canonical(const std::string& heading, const std::map<std::size_t, std::string>& rows) {
  std::string text = heading + "\n";
  for (const auto& [run, row] : rows) text += row + "\n";
  return text;
}

void make_folder_of(const std::string& file) {
  std::error_code why;  // if it cannot be made, opening the file says so
  if (const auto folder = std::filesystem::path(file).parent_path(); !folder.empty())
    std::filesystem::create_directories(folder, why);
}

// The rows' file itself cannot carry the lock, as another one takes its place.
FileLock::FileLock(std::string_view flag, const std::string& file) : path_(file + ".lock") {
  do {
    if (fd_ >= 0) ::close(fd_);
    fd_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR);
    if (fd_ < 0)
      throw UserError(std::string(flag) + ": cannot write '" + path_ + "': " + std::generic_category().message(errno));
    // A file system without locks gives another reason, and the run goes on.
    if (::flock(fd_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      ::close(fd_);
      throw UserError(std::string(flag) + ": " + file +
                      ": another padr-lab is writing it; wait for its end, or give another file");
    }
  } while (!is_in_place());
}

FileLock::~FileLock() {
  ::unlink(path_.c_str());  // while it is held: whoever has opened it meanwhile sees that it is gone
  ::close(fd_);
}

bool FileLock::is_in_place() const {
  struct stat ours {};
  struct stat there {};
  return ::fstat(fd_, &ours) == 0 && ::stat(path_.c_str(), &there) == 0 && ours.st_ino == there.st_ino;
}

void replace_file(std::string_view flag, const std::string& file, const std::string& text) {
  make_folder_of(file);
  shell::replace_text(flag, file, text);
}

}  // namespace padr::lab::sweep
