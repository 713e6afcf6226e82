#include "tools/lab/sweep/digest.h"

#include <fmt/printf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>

#include "shell/text.h"
#include "tools/lab/simulation.h"

namespace padr::lab::sweep {
namespace {

constexpr std::size_t kFirstKey = 3;  // behind grid, run and of

/// Half of the 95 % interval of a mean of `n` values, 2 or more, with this standard deviation, by Student's t.
double half_interval(double n, double deviation) {
  // The 97.5 % point for 1, 2, ... degrees of freedom; beyond them its expansion around the normal distribution's.
  // Both are right to six digits, which is what a summary prints.
  constexpr std::array<double, 16> kPoint{12.70620474, 4.30265273, 3.18244631, 2.77644511, 2.57058184, 2.44691185,
                                          2.36462425,  2.30600414, 2.26215716, 2.22813885, 2.20098516, 2.17881283,
                                          2.16036866,  2.14478669, 2.13144955, 2.1199053};
  const auto freedom = static_cast<std::size_t>(n) - 1;
  const double part = 1 / static_cast<double>(freedom);
  const double point =
      freedom <= kPoint.size()
          ? kPoint[freedom - 1]
          : 1.95996398 + part * (2.37227123 + part * (2.82249862 + part * (2.55584968 + part * 1.58953405)));
  return point * deviation / std::sqrt(n);
}

/// Mean and spread of a column (Welford's sums).
struct Column {
  double n = 0, mean = 0, squares = 0;
  void add(double v) {
    n += 1;
    const double off = v - mean;
    mean += off / n;
    squares += off * (v - mean);
  }
  /// By a printf format; of a single value there is none.
  std::string interval(const char* format, const char* none) const {
    return n < 2 ? none : fmt::sprintf(format, half_interval(n, std::sqrt(squares / (n - 1))));
  }
};

/// The seeds of one combination.
struct Group {
  std::vector<std::string> key;
  std::vector<Column> columns;  ///< by place; those before the outcome stay empty
  double n() const { return columns.back().n; }
};

/// Where this column is; names.size() if it is not there.
std::size_t place_of(const std::vector<std::string>& names, std::string_view name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

double as_number(const std::string& field) {
  return std::strtod(field.c_str(), nullptr);
}

/// Where the columns are that the table shows.
struct Places {
  explicit Places(const std::vector<std::string>& names) {
    const auto place = [&names](const char* name) { return place_of(names, name); };
    seed = place("seed");
    mean = place("mean_m");
    avatars = place("avatar_mean_m");
    bodies = place("body_mean_m");
    peak = place("peak_m");
    kbps = place("wire_kbps");
    fidelity = place("fidelity_mean_m");
    has_fidelity = fidelity < names.size();
    complete = std::max({seed, mean, avatars, bodies, peak, kbps}) < names.size();
  }
  std::size_t seed, mean, avatars, bodies, peak, kbps, fidelity;
  bool complete;
  bool has_fidelity;  ///< older files have none
};

std::vector<Group> grouped(const StoredRows& stored, std::size_t seed) {
  std::vector<Group> groups;
  std::map<std::vector<std::string>, std::size_t> place;
  for (const StoredRow& stored_row : stored.rows) {
    const std::vector<std::string> row = fields_of(stored_row.text);
    std::vector<std::string> key(row.begin() + kFirstKey, row.begin() + static_cast<std::ptrdiff_t>(seed));
    const auto [found, fresh] = place.try_emplace(key, groups.size());
    if (fresh) groups.push_back({std::move(key), std::vector<Column>(row.size())});
    Group& g = groups[found->second];
    for (std::size_t c = seed + 1; c < row.size(); ++c) g.columns[c].add(as_number(row[c]));
  }
  return groups;
}

std::string line_of(const Group& g, const Places& at) {
  const auto mean = [&g](std::size_t column) { return g.columns[column].mean; };
  return fmt::sprintf("%6.0f %8.3f %7s %8.3f %8.3f %8.2f ", g.n(), mean(at.mean),
                      g.columns[at.mean].interval("%.3f", "-"), mean(at.avatars), mean(at.bodies), mean(at.peak)) +
         (at.has_fidelity ? fmt::sprintf("%9.3f ", mean(at.fidelity)) : "") + fmt::sprintf("%8.1f\n", mean(at.kbps));
}

/// Whether means of a column say something: `setting` and the like are words, `confirmed_hash` is a name.
bool is_measure(const StoredRows& stored, std::size_t column, const std::string& name) {
  if (name == "seconds" || name == "confirmed_hash") return false;
  return std::all_of(stored.rows.begin(), stored.rows.end(), [column](const StoredRow& row) {
    const std::string field = fields_of(row.text)[column];
    char* end = nullptr;
    std::strtod(field.c_str(), &end);
    return !field.empty() && *end == '\0';
  });
}

std::string line_of_fields(const std::vector<std::string>& fields) {
  std::string line;
  for (const std::string& f : fields) line += (line.empty() ? "" : ",") + shell::csv_field(f);
  return line + "\n";
}

}  // namespace

std::string digest(const StoredRows& stored, std::size_t most) {
  const std::vector<std::string> names = fields_of(stored.heading);
  const Places at(names);
  if (!at.complete || stored.rows.empty()) return "";
  const std::vector<Group> groups = grouped(stored, at.seed);
  if (groups.size() > most) return fmt::sprintf("%zu combinations: too many for a table here\n", groups.size());
  std::string fixed;
  std::string heading;
  std::vector<std::size_t> widths(groups.front().key.size(), 0);
  for (std::size_t k = 0; k < widths.size(); ++k) {
    const std::string& name = names[kFirstKey + k];
    const bool alike =
        std::all_of(groups.begin(), groups.end(), [&](const Group& g) { return g.key[k] == groups.front().key[k]; });
    if (alike) {
      fixed += (fixed.empty() ? "" : ", ") + name + " " + groups.front().key[k];
      continue;
    }
    widths[k] = name.size();
    for (const Group& g : groups) widths[k] = std::max(widths[k], g.key[k].size());
    heading += fmt::sprintf("%-*s  ", static_cast<int>(widths[k]), name.c_str());
  }
  std::string text = fixed + "; inconsistency in m, means over seeds; mean +- half of its 95 % interval\n" + heading +
                     "  runs     mean      +-  avatars   bodies     peak   " + (at.has_fidelity ? "fidelity   " : "") +
                     "kbit/s\n";
  for (const Group& g : groups) {
    for (std::size_t k = 0; k < widths.size(); ++k)
      if (widths[k] > 0) text += fmt::sprintf("%-*s  ", static_cast<int>(widths[k]), g.key[k].c_str());
    text += line_of(g, at);
  }
  return text;
}

bool agreed(const StoredRows& stored) {
  const std::vector<std::string> names = fields_of(stored.heading);
  const std::size_t mismatches = place_of(names, "confirmed_mismatches");
  return mismatches == names.size() ||
         std::all_of(stored.rows.begin(), stored.rows.end(),
                     [mismatches](const StoredRow& row) { return as_number(fields_of(row.text)[mismatches]) == 0; });
}

std::string doubt(const StoredRows& stored) {
  const std::vector<std::string> names = fields_of(stored.heading);
  const std::size_t seconds = place_of(names, "seconds");
  const std::size_t confirmed = place_of(names, "confirmed_ticks");
  if (std::max(seconds, confirmed) == names.size()) return "";
  std::size_t rows = 0;
  std::pair<double, std::size_t> least{1, 0};  // share, run
  for (const StoredRow& row : stored.rows) {
    const std::vector<std::string> fields = fields_of(row.text);
    const double ticks = as_number(fields[seconds]) * kTicksPerSecond;
    const double share = as_number(fields[confirmed]) / ticks;
    if (!Simulation::is_little(share, static_cast<Tick>(ticks))) continue;
    ++rows;
    least = std::min(least, {share, row.run});
  }
  if (rows == 0) return "";
  return fmt::sprintf(
      "in %zu of %zu runs inconsistency was measured at a part of the ticks only, in run %zu at the first %.0f %%: the "
      "others were not confirmed in time; see the column confirmed_ticks",
      rows, stored.rows.size(), least.second, 100 * least.first);
}

std::string summary(const StoredRows& stored) {
  const std::vector<std::string> names = fields_of(stored.heading);
  const Places at(names);
  if (!at.complete || stored.rows.empty()) return "";
  std::vector<std::size_t> measures;
  for (std::size_t c = at.seed + 1; c < names.size(); ++c)
    if (is_measure(stored, c, names[c])) measures.push_back(c);
  std::vector<std::string> fields(names.begin() + kFirstKey, names.begin() + static_cast<std::ptrdiff_t>(at.seed));
  fields.emplace_back("runs");
  for (const std::size_t c : measures) fields.insert(fields.end(), {names[c], names[c] + "_interval"});
  std::string text = line_of_fields(fields);
  for (const Group& g : grouped(stored, at.seed)) {
    fields = g.key;
    fields.push_back(fmt::sprintf("%.0f", g.n()));
    for (const std::size_t c : measures)
      fields.insert(fields.end(), {fmt::sprintf("%.6g", g.columns[c].mean), g.columns[c].interval("%.6g", "")});
    text += line_of_fields(fields);
  }
  return text;
}

}  // namespace padr::lab::sweep
