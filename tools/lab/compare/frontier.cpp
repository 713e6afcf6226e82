#include <algorithm>
#include <cctype>

#include "tools/lab/compare/comparison.h"
#include "tools/plot/plot.h"

namespace padr::lab::compare {
namespace {

// m; a logarithmic axis has no zero, and this is far below what is noise.
constexpr double kLeast = 0.002;

enum class PictureKind : std::uint8_t {
  kFrontier,
  kHands,      ///< the same against where the hands of now put things
  kAblations,  ///< crowd round full: they have a picture of their own
};

std::string beginning_of(PictureKind kind) {
  switch (kind) {
    case PictureKind::kFrontier:
      return "frontier_";
    case PictureKind::kHands:
      return "hands_";
    case PictureKind::kAblations:
      return "ablations_";
  }
  return "";
}

bool belongs(const Contestant& c, PictureKind kind) {
  return c.id == "full" || (c.group == Group::kAblation) == (kind == PictureKind::kAblations);
}

double height_of(const Row& row, PictureKind kind) {
  return kind == PictureKind::kHands ? row.over([](const Score& s) { return s.hands_mean_m; }).mean : row.mean_m();
}

plot::MarkSeries& series_of(const Contestant& c, plot::ScatterPlot& p) {
  const auto known =
      std::find_if(p.series.begin(), p.series.end(), [&c](const plot::MarkSeries& s) { return s.title == c.series; });
  if (known != p.series.end()) return *known;
  plot::MarkSeries fresh;
  fresh.title = c.series;
  fresh.joined = c.group != Group::kPaper && c.group != Group::kAblation && c.id.substr(0, 10) != "everything";
  p.series.push_back(std::move(fresh));
  return p.series.back();
}

plot::ScatterPlot picture(const std::vector<Row>& rows, const Plan& plan, const Network& network, PictureKind kind) {
  plot::ScatterPlot p;
  p.title = plan.setting.scenario + ", " + std::to_string(plan.setting.peers) + " peers, " +
            (network.text.empty() ? "no delay" : network.text) +
            (kind == PictureKind::kAblations ? "" : "; numbers: Hz, kbit/s, or input delay in ticks");
  p.canvas = {1000, 760, 14};
  p.x.label = "sent by a peer, headers included (kbit/s)";
  p.x.log = kind != PictureKind::kAblations;
  p.y.label = std::string("mean combined inconsistency") + (kind == PictureKind::kHands ? " against hands" : "") +
              " (m), at least 0.002";
  p.y.log = true;
  for (const Row& r : rows)
    if (r.network == network.text && belongs(r.who, kind))
      series_of(r.who, p).marks.push_back({r.kbps(), std::max(height_of(r, kind), kLeast), r.who.mark});
  for (plot::MarkSeries& s : p.series)
    if (s.title == "full")
      std::sort(s.marks.begin(), s.marks.end(), [](const plot::Mark& a, const plot::Mark& b) { return a.x < b.x; });
  return p;
}

/// A mark and a colour of its own for each series.
void give_looks(plot::ScatterPlot& p) {
  std::vector<std::string> titles;
  for (const plot::MarkSeries& s : p.series) titles.push_back(s.title);
  const std::vector<plot::Look> looks = plot::distinct_looks(titles);
  for (std::size_t i = 0; i < looks.size(); ++i) p.series[i].look = looks[i];
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
  return beginning_of(PictureKind::kFrontier) + file_name(network);
}

plot::Drawing draw_frontiers(const std::vector<Row>& rows, const Plan& plan, const std::string& dir) {
  std::vector<std::string> names;
  for (const Network& n : plan.networks) {
    for (const PictureKind kind : {PictureKind::kFrontier, PictureKind::kHands, PictureKind::kAblations}) {
      plot::ScatterPlot p = picture(rows, plan, n, kind);
      if (p.series.size() < 2) continue;
      give_looks(p);
      p.name = beginning_of(kind) + file_name(n.text);
      plot::write_into("--out", dir, plot::files(p));
      names.push_back(p.name);
    }
  }
  return plot::draw(dir, names);
}

}  // namespace padr::lab::compare
