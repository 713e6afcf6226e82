#include <algorithm>
#include <cctype>

#include "tools/lab/compare/comparison.h"
#include "tools/plot/plot.h"

namespace padr::lab::compare {
namespace {

// m; a logarithmic axis has no zero, and this is far below what is noise.
constexpr double kLeast = 0.002;

/// Ablations crowd round full: they have a picture of their own.
bool belongs(const Contestant& c, bool ablations) {
  return c.id == "full" || (c.group == Group::kAblation) == ablations;
}

plot::MarkSeries& series_of(const Contestant& c, plot::ScatterPlot& p) {
  const auto known =
      std::find_if(p.series.begin(), p.series.end(), [&c](const plot::MarkSeries& s) { return s.title == c.series; });
  if (known != p.series.end()) return *known;
  // What looks like a series that is there already is told apart by its marks.
  const auto alike = std::count_if(p.series.begin(), p.series.end(), [&c](const plot::MarkSeries& s) {
    return s.look.colour == plot::colour_of(c.series) && s.title.substr(0, 4) == c.series.substr(0, 4);
  });
  const int variant = c.id == "everything-no-replay" ? 0 : static_cast<int>(alike);
  plot::MarkSeries fresh;
  fresh.title = c.series;
  fresh.look = plot::look_of(c.series, variant);
  fresh.joined = c.group != Group::kPaper && c.group != Group::kAblation && c.id.substr(0, 10) != "everything";
  p.series.push_back(std::move(fresh));
  return p.series.back();
}

plot::ScatterPlot frontier(const std::vector<Row>& rows, const Plan& plan, const Network& network, bool ablations) {
  plot::ScatterPlot p;
  p.title = plan.setting.scenario + ", " + std::to_string(plan.setting.peers) + " peers, " +
            (network.text.empty() ? "no delay" : network.text);
  p.x.label = "sent by a peer, headers included (kbit/s)";
  p.x.log = !ablations;
  p.y.label = "mean combined inconsistency (m), at least 0.002";
  p.y.log = true;
  for (const Row& r : rows)
    if (r.network == network.text && belongs(r.who, ablations))
      series_of(r.who, p).marks.push_back({r.kbps(), std::max(r.mean_m(), kLeast), r.who.mark});
  for (plot::MarkSeries& s : p.series)
    if (s.title == "full")
      std::sort(s.marks.begin(), s.marks.end(), [](const plot::Mark& a, const plot::Mark& b) { return a.x < b.x; });
  return p;
}

std::string file_name(const std::string& network) {
  std::string name;
  for (const char c : network) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0;
    if (plain || (!name.empty() && name.back() != '_')) name += plain ? c : '_';
  }
  return name.empty() ? "clean" : name;
}

}  // namespace

std::string frontier_name(const std::string& network) {
  return "frontier_" + file_name(network);
}

std::string draw_frontiers(const std::vector<Row>& rows, const Plan& plan, const std::string& dir) {
  std::vector<std::string> names;
  for (const Network& n : plan.networks) {
    for (const bool ablations : {false, true}) {
      plot::ScatterPlot p = frontier(rows, plan, n, ablations);
      if (p.series.size() < 2) continue;
      p.name = ablations ? "ablations_" + file_name(n.text) : frontier_name(n.text);
      plot::write_into("--out", dir, plot::files(p));
      names.push_back(p.name);
    }
  }
  return plot::draw(dir, names);
}

}  // namespace padr::lab::compare
