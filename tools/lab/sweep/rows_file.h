#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace padr::lab::sweep {

/// A row of a sweep's CSV as it stands in a file.
struct StoredRow {
  std::string grid;      ///< id of the grid it is of
  std::size_t run = 0;   ///< which run of it, 0 .. of-1
  std::size_t of = 0;    ///< how many there are in all
  std::string text;      ///< the whole line, without its newline
  std::size_t line = 0;  ///< where it stands, from 1
};

struct StoredRows {
  std::string heading;  ///< first line, without its newline
  std::vector<StoredRow> rows;
  std::string rest;  ///< what is behind the last newline: if anything, whoever wrote the file was stopped
};

/// Throws UserError "FLAG: FILE:LINE: ..." for a line that is no row of a sweep, or has a measure that is no number.
StoredRows read_rows(std::string_view flag, const std::string& file);

/// The fields of a line, without the quotes that some need (RFC 4180).
std::vector<std::string> fields_of(std::string_view line);

/// The file with all these rows in the order of their runs: its canonical form.
std::string canonical(const std::string& heading, const std::map<std::size_t, std::string>& rows);

/// Makes the folder that the file is to be in, if there is none.
void make_folder_of(const std::string& file);

/// FILE.lock, which says to other processes that the file is being written; it goes with this object. A killed process
/// may leave one behind, which holds up nobody.
class FileLock {
 public:
  /// Throws UserError, which names the flag, if another one has the lock.
  FileLock(std::string_view flag, const std::string& file);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  bool is_in_place() const;
  std::string path_;
  int fd_ = -1;
};

/// As shell::replace_text() does, in a folder that is made if there is none.
void replace_file(std::string_view flag, const std::string& file, const std::string& text);

}  // namespace padr::lab::sweep
