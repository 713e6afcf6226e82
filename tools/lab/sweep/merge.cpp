#include <algorithm>
#include <map>

#include "common/model/user_error.h"
#include "tools/lab/sweep/rows_file.h"
#include "tools/lab/sweep/sweep.h"

namespace padr::lab::sweep {
namespace {

struct Whole {
  std::string heading;
  std::string grid;
  std::size_t of = 0;
  std::string first_file;
  std::map<std::size_t, std::string> rows;
  std::map<std::size_t, std::string> file_of;
};

void add(Whole& whole, const std::string& file) {
  const StoredRows stored = read_rows("SHARD", file);
  if (!stored.rest.empty() || stored.heading.empty())
    throw UserError("SHARD: " + file + ": its end is cut off; run the same sweep again to complete it");
  if (whole.heading.empty()) {
    whole.heading = stored.heading;
    whole.first_file = file;
  }
  if (stored.heading != whole.heading)
    throw UserError("SHARD: " + file + ":1: has other columns than " + whole.first_file);
  for (const StoredRow& row : stored.rows) {
    const std::string where = "SHARD: " + file + ":" + std::to_string(row.line) + ": ";
    if (whole.grid.empty()) {
      whole.grid = row.grid;
      whole.of = row.of;
    }
    if (row.grid != whole.grid || row.of != whole.of)
      throw UserError(where + "is of grid " + row.grid + " with " + std::to_string(row.of) + " runs, " +
                      whole.first_file + " is of grid " + whole.grid + " with " + std::to_string(whole.of));
    const auto [there, fresh] = whole.file_of.try_emplace(row.run, file);
    if (!fresh) throw UserError(where + "run " + std::to_string(row.run) + " is in " + there->second + " too");
    whole.rows[row.run] = row.text;
  }
}

/// "runs 3, 7, 11 and 9 more", empty if none is missing.
std::string missing(const Whole& whole) {
  constexpr std::size_t kNamed = 5;
  const std::size_t n = whole.of - whole.rows.size();  // read_rows() takes no run beyond the last
  if (n == 0) return "";
  std::string names;
  std::size_t named = 0;
  for (std::size_t run = 0; named < std::min(n, kNamed); ++run) {
    if (whole.rows.contains(run)) continue;
    names += (named++ == 0 ? "" : ", ") + std::to_string(run);
  }
  return (n == 1 ? "run " : "runs ") + names + (n > kNamed ? " and " + std::to_string(n - kNamed) + " more" : "");
}

}  // namespace

std::size_t merge(const std::vector<std::string>& shards, const std::string& out) {
  Whole whole;
  for (const std::string& file : shards) add(whole, file);
  if (whole.of == 0) throw UserError("SHARD: none of the files has a row");
  const std::string holes = missing(whole);
  if (!holes.empty())
    throw UserError("SHARD: " + holes + " of " + std::to_string(whole.of) +
                    " missing: a shard is not here, or not complete");
  replace_file("--out", out, canonical(whole.heading, whole.rows));
  return whole.rows.size();
}

}  // namespace padr::lab::sweep
