#include "tools/lab/sweep/digest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>

namespace padr::lab::sweep {
namespace {

constexpr std::size_t kFirstKey = 3;  // behind grid, run and of

template <typename... Args>
std::string format(const char* pattern, Args... args) {
  std::array<char, 200> text{};
  const int n = std::snprintf(text.data(), text.size(), pattern, args...);
  return {text.data(), static_cast<std::size_t>(n)};
}

/// Sums over the seeds of one combination.
struct Group {
  std::vector<std::string> key;
  double n = 0, mean = 0, mean_squared = 0, avatars = 0, bodies = 0, peak = 0, kbps = 0, fidelity = 0;
};

/// Where the columns are that the table shows.
struct Places {
  explicit Places(const std::vector<std::string>& names) {
    const auto place = [&names](const char* name) {
      return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    };
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

std::vector<Group> grouped(const std::vector<std::vector<std::string>>& rows, const Places& at) {
  std::vector<Group> groups;
  std::map<std::vector<std::string>, std::size_t> place;
  for (const auto& row : rows) {
    std::vector<std::string> key(row.begin() + kFirstKey, row.begin() + static_cast<std::ptrdiff_t>(at.seed));
    const auto [found, fresh] = place.try_emplace(key, groups.size());
    if (fresh) groups.push_back({std::move(key)});
    Group& g = groups[found->second];
    const auto value = [&row](std::size_t column) { return std::strtod(row[column].c_str(), nullptr); };
    g.n += 1;
    g.mean += value(at.mean);
    g.mean_squared += value(at.mean) * value(at.mean);
    g.avatars += value(at.avatars);
    g.bodies += value(at.bodies);
    g.peak += value(at.peak);
    g.kbps += value(at.kbps);
    if (at.has_fidelity) g.fidelity += value(at.fidelity);
  }
  return groups;
}

std::string line_of(const Group& g, bool has_fidelity) {
  const double mean = g.mean / g.n;
  const double spread = g.n > 1 ? std::sqrt(std::max(0.0, (g.mean_squared - g.n * mean * mean) / (g.n - 1))) : 0;
  return format("%6.0f %8.3f %7.3f %8.3f %8.3f %8.2f ", g.n, mean, spread / std::sqrt(g.n), g.avatars / g.n,
                g.bodies / g.n, g.peak / g.n) +
         (has_fidelity ? format("%9.3f ", g.fidelity / g.n) : "") + format("%8.1f\n", g.kbps / g.n);
}

}  // namespace

std::string digest(const StoredRows& stored, std::size_t most) {
  const std::vector<std::string> names = fields_of(stored.heading);
  const Places at(names);
  if (!at.complete || stored.rows.empty()) return "";
  std::vector<std::vector<std::string>> rows;
  for (const StoredRow& r : stored.rows) rows.push_back(fields_of(r.text));
  const std::vector<Group> groups = grouped(rows, at);
  if (groups.size() > most) return format("%zu combinations: too many for a table here\n", groups.size());
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
    heading += format("%-*s  ", static_cast<int>(widths[k]), name.c_str());
  }
  std::string text = fixed + "; inconsistency in m, means over seeds, and the standard error of the mean\n" + heading +
                     "  runs     mean      +-  avatars   bodies     peak   " + (at.has_fidelity ? "fidelity   " : "") +
                     "kbit/s\n";
  for (const Group& g : groups) {
    for (std::size_t k = 0; k < widths.size(); ++k)
      if (widths[k] > 0) text += format("%-*s  ", static_cast<int>(widths[k]), g.key[k].c_str());
    text += line_of(g, at.has_fidelity);
  }
  return text;
}

}  // namespace padr::lab::sweep
