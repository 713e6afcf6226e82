#include "tools/lab/sweep/sweep.h"

#include <charconv>
#include <filesystem>
#include <map>
#include <mutex>

#include "common/model/user_error.h"
#include "shell/files.h"
#include "tools/lab/sweep/row.h"
#include "tools/lab/sweep/rows_file.h"

namespace padr::lab::sweep {
namespace {

constexpr std::size_t kMostShards = 1'000'000;

/// The rows that the file has already; throws if they are of something else.
std::map<std::size_t, std::string> rows_done(const Runs& runs, const Shard& shard, const std::string& file) {
  std::map<std::size_t, std::string> done;
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return done;
  const StoredRows stored = read_rows(runs.flag, file);
  // Stopped within the heading: nothing was done.
  if (stored.heading.empty() && runs.heading.starts_with(stored.rest)) return done;
  if (stored.heading.empty())
    throw UserError(runs.flag + ": " + file + ":1: is not the heading of a sweep, which begins grid,run,of");
  for (const StoredRow& row : stored.rows) {
    const std::string where = runs.flag + ": " + file + ":" + std::to_string(row.line);
    if (row.grid != runs.id || row.of != runs.size)
      throw UserError(where + ": is of grid " + row.grid + ", this one is " + runs.id +
                      " (other lists, a file or a contestant that has changed, another revision or another machine's "
                      "physics); give another file, or delete this one");
    if (!shard.has(row.run))
      throw UserError(where + ": run " + std::to_string(row.run) + " is not of shard " + std::to_string(shard.index) +
                      "/" + std::to_string(shard.count) + "; give another file");
    done[row.run] = row.text;
  }
  if (stored.heading != runs.heading)
    throw UserError(runs.flag + ": " + file +
                    ":1: has other columns than this grid; give another file, or delete this one");
  return done;
}

}  // namespace

Shard shard_of(const std::string& text) {
  if (text.empty()) return {};
  Shard s;
  const std::size_t slash = text.find('/');
  const auto number = [&](std::string_view t, std::size_t& v) {
    const auto [end, error] = std::from_chars(t.data(), t.data() + t.size(), v);
    return error == std::errc() && end == t.data() + t.size();
  };
  const bool fine = slash != std::string::npos && number(std::string_view(text).substr(0, slash), s.index) &&
                    number(std::string_view(text).substr(slash + 1), s.count);
  if (!fine || s.index < 1 || s.index > s.count || s.count > kMostShards)
    throw UserError("--shard: '" + text + "' is not allowed; give I/N with I from 1 to N, and N up to 1000000");
  return s;
}

SweepResult run_missing(const Runs& runs, const Shard& shard, const std::string& file,
                        const ParallelOptions& parallel) {
  const std::string place = shell::replaceable(runs.flag, file);
  make_folder_of(place);
  const FileLock lock(runs.flag, place);
  std::map<std::size_t, std::string> rows = rows_done(runs, shard, file);
  std::vector<std::size_t> todo;
  SweepResult result;
  for (std::size_t run = shard.index - 1; run < runs.size; run += shard.count) {
    ++result.runs;
    if (!rows.contains(run)) todo.push_back(run);
  }
  result.done_now = todo.size();

  // The file is written anew beside the old one, which stays until the new one has all its rows.
  const std::string part = place + ".part";
  shell::OutputFile out(runs.flag, part);
  out.write(canonical(runs.heading, rows));
  out.flush();
  std::filesystem::rename(part, place);
  std::mutex mutex;
  run_parallel(
      todo.size(),
      [&](std::size_t i) {
        std::string row = runs.row(todo[i]);
        const std::lock_guard guard(mutex);
        out.write(row + "\n");
        out.flush();
        rows[todo[i]] = std::move(row);
      },
      parallel);
  out.close();
  replace_file(runs.flag, file, canonical(runs.heading, rows));
  return result;
}

SweepResult run_sweep(const Grid& grid, const Shard& shard, const std::string& file, const ParallelOptions& parallel) {
  const auto row = [&grid](std::size_t run) { return run_point(grid, run); };
  return run_missing({grid.id(), grid.size(), heading_of(grid), row}, shard, file, parallel);
}

}  // namespace padr::lab::sweep
