#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>
#include <string_view>

#include "shell/text.h"
#include "tools/plot/palette.h"
#include "tools/report/outputs.h"

namespace padr::report {
namespace {

using shell::fixed;

constexpr std::string_view kGrey = "#BBBBBB";
constexpr std::string_view kMissing = " ?";
// More lines than this are no longer told apart: a band and its mean are drawn instead.
constexpr std::size_t kMostLines = 7;
// Points along the time axis at most.
constexpr std::size_t kMostPoints = 1800;
constexpr std::size_t kMostBars = 240;

using plot::colour_by_number;
using plot::script;

std::string quoted(std::string_view s) {
  return plot::in_quotes(s);
}

plot::Canvas canvas(int height) {
  return {.height = height};
}

Tick longest(const Report& r) {
  Tick t = 1;
  for (const Peer& p : r.peers) t = std::max(t, p.went());
  return t;
}

std::string time_axis(const Report& r) {
  return "set xrange [0:" + fixed(static_cast<double>(longest(r)) / kTicksPerSecond, 3) + "]\n";
}

// --- inconsistency over time

/// Means over bins of `width` ticks; by bin, then peer; -1 where a peer has nothing.
std::vector<std::vector<double>> binned(const Report& r, std::size_t width, bool bodies_only) {
  const std::size_t bins = static_cast<std::size_t>(longest(r)) / width + 1;
  std::vector<std::vector<double>> sums(bins, std::vector<double>(r.peers.size(), 0));
  std::vector<std::vector<int>> counts(bins, std::vector<int>(r.peers.size(), 0));
  for (std::size_t p = 0; p < r.peers.size(); ++p) {
    for (const trace::InconsistencyPoint& i : r.peers[p].series) {
      const std::size_t bin = static_cast<std::size_t>(i.tick) / width;
      sums[bin][p] += static_cast<double>(bodies_only ? i.bodies_m : i.combined());
      ++counts[bin][p];
    }
  }
  for (std::size_t b = 0; b < bins; ++b)
    for (std::size_t p = 0; p < r.peers.size(); ++p) sums[b][p] = counts[b][p] == 0 ? -1 : sums[b][p] / counts[b][p];
  return sums;
}

/// Columns: seconds; peers' values, or minimum, maximum and mean if they are many.
void put_columns(std::string& s, const std::vector<double>& values) {
  if (values.size() <= kMostLines) {
    for (const double v : values) s += v < 0 ? std::string(kMissing) : ' ' + fixed(v, 6);
    return;
  }
  double low = std::numeric_limits<double>::max();
  double high = 0;
  double sum = 0;
  int n = 0;
  for (const double v : values) {
    if (v < 0) continue;
    low = std::min(low, v);
    high = std::max(high, v);
    sum += v;
    ++n;
  }
  if (n == 0) {
    for (int i = 0; i < 3; ++i) s += kMissing;
  } else {
    for (const double v : {low, high, sum / n}) s += ' ' + fixed(v, 6);
  }
}

std::string inconsistency_curves(const Report& r, std::size_t first_column, bool titles) {
  std::string s = "plot 0.005 dt 3 lw 1.5 lc rgb '#777777' title " + quoted(titles ? "5 mm: noise below" : "");
  const auto column = [first_column](std::size_t i) { return std::to_string(first_column + i); };
  if (r.peers.size() > kMostLines) {
    s += ", 'inconsistency.dat' using 1:" + column(0) + ":" + column(1) +
         " with filledcurves fs transparent solid 0.3 lc rgb " + quoted(colour_by_number(4)) + " title " +
         quoted(titles ? "range of peers" : "");
    s += ", '' using 1:" + column(2) + " with lines lw 1.8 lc rgb " + quoted(colour_by_number(0)) + " title " +
         quoted(titles ? "mean of peers" : "");
    return s + "\n";
  }
  std::map<PeerId, int> lives;
  for (std::size_t p = 0; p < r.peers.size(); ++p) {
    const PeerId slot = r.peers[p].header.peer;
    // The colour is the slot's: dashes tell apart those that share it.
    const int dash = (slot / static_cast<int>(plot::kColours) + lives[slot]++) % 5;
    s += ", 'inconsistency.dat' using 1:" + column(p) + " with lines lw 1.4 dt " + std::to_string(1 + dash) +
         " lc rgb " + quoted(colour_by_number(slot)) + " title " + quoted(titles ? "peer " + r.peers[p].name : "");
  }
  return s + "\n";
}

void inconsistency_plot(const Report& r, std::vector<NamedText>& out) {
  const std::size_t width = static_cast<std::size_t>(longest(r)) / kMostPoints + 1;
  const auto combined = binned(r, width, false);
  const auto bodies = binned(r, width, true);
  std::string data = "# seconds, combined inconsistency (m), bodies' part (m)\n";
  for (std::size_t b = 0; b < combined.size(); ++b) {
    data += fixed(static_cast<double>(b * width) / kTicksPerSecond, 4);
    put_columns(data, combined[b]);
    put_columns(data, bodies[b]);
    data += '\n';
  }
  const std::size_t columns = r.peers.size() > kMostLines ? 3 : r.peers.size();
  const std::string mean = width > 1 ? ", mean of " + std::to_string(width) + " ticks" : "";
  std::string body = "set multiplot layout 2,1\nset lmargin 12\nset rmargin 26\nset yrange [0:*]\n" + time_axis(r);
  body += "set title 'Combined inconsistency of each peer" + mean + "'\nset xlabel ''\nset ylabel 'all entities (m)'\n";
  body += inconsistency_curves(r, 2, true);
  body += "set title 'The part of bodies'\nset xlabel 'session time (s)'\nset ylabel 'bodies (m)'\n";
  body += inconsistency_curves(r, 2 + columns, false);
  body += "unset multiplot\n";
  out.push_back({"inconsistency.dat", data});
  out.push_back(script("inconsistency", canvas(640), body));
}

// --- traffic over time by cause

struct Layer {
  std::string title;
  std::string_view colour;
  std::vector<double> kbps;     ///< by bar
  std::vector<double> updates;  ///< per second, by bar
};

std::vector<Traffic> bars_of(const Report& r, std::size_t width) {
  std::vector<Traffic> bars;
  for (const Peer& p : r.peers) {
    for (std::size_t second = 0; second < p.per_second.size(); ++second) {
      if (second / width >= bars.size()) bars.resize(second / width + 1);
      bars[second / width] += p.per_second[second];
    }
  }
  return bars;
}

/// Whose time falls in a bar.
struct Presence {
  double seconds = 0;  ///< of all peers
  int peers = 0;
};

/// By bar. Peers are there from their coming, which may be late, until they go.
std::vector<Presence> presence_in_bars(const Report& r, std::size_t bars, std::size_t width) {
  std::vector<Presence> all(bars);
  for (const Peer& p : r.peers) {
    const double came = static_cast<double>(p.came) / kTicksPerSecond;
    const double went = static_cast<double>(p.went()) / kTicksPerSecond;
    for (std::size_t b = 0; b < bars; ++b) {
      const auto from = static_cast<double>(b * width);
      const double there = std::min(went, from + static_cast<double>(width)) - std::max(came, from);
      if (there <= 0) continue;
      all[b].seconds += there;
      ++all[b].peers;
    }
  }
  return all;
}

std::vector<Layer> layers_of(const Report& r, std::size_t width) {
  const std::vector<Traffic> bars = bars_of(r, width);
  const std::vector<Presence> presence = presence_in_bars(r, bars.size(), width);
  std::vector<Layer> layers{{"headers, marks, acks", kGrey, {}, {}}, {"repeats", "#777777", {}, {}}};
  for (std::size_t c = 0; c < sync::kCauses; ++c) {
    std::string title(sync::kCauseNames[c]);
    std::replace(title.begin(), title.end(), '_', ' ');
    layers.push_back({title, colour_by_number(c), {}, {}});
  }
  for (std::size_t b = 0; b < bars.size(); ++b) {
    // What little is left over after the last full second says nothing about a rate.
    const double scale = presence[b].seconds < 0.25 * std::max(presence[b].peers, 1) ? 0 : 1 / presence[b].seconds;
    layers[0].kbps.push_back(bars[b].bytes_rest() * 0.008 * scale);
    layers[1].kbps.push_back(bars[b].bytes_repeats * 0.008 * scale);
    layers[1].updates.push_back(static_cast<double>(bars[b].repeats) * scale);
    for (std::size_t c = 0; c < sync::kCauses; ++c) {
      layers[c + 2].kbps.push_back(bars[b].bytes_by_cause[c] * 0.008 * scale);
      layers[c + 2].updates.push_back(static_cast<double>(bars[b].updates[c]) * scale);
    }
  }
  layers[0].updates.assign(bars.size(), 0);
  layers[1].updates.assign(bars.size(), 0);
  std::erase_if(layers, [](const Layer& l) {
    return std::all_of(l.kbps.begin(), l.kbps.end(), [](double v) { return v == 0; });
  });
  return layers;
}

/// Stacked: the whole pile first, then each pile without its topmost layer over it.
std::string piles(const std::vector<Layer>& layers, std::size_t first_column, bool titles) {
  std::string s = "plot ";
  for (std::size_t i = layers.size(); i-- > 0;) {
    s += i + 1 == layers.size() ? "'traffic.dat'" : ", ''";
    s += " using 1:" + std::to_string(first_column + i) + " with boxes fs solid 1 noborder lc rgb " +
         quoted(layers[i].colour) + " title " + quoted(titles ? layers[i].title : "");
  }
  return layers.empty() ? "plot NaN notitle\n" : s + "\n";
}

void traffic_plot(const Report& r, std::vector<NamedText>& out) {
  const std::size_t width = static_cast<std::size_t>(longest(r) / kTicksPerSecond) / kMostBars + 1;
  const std::vector<Layer> layers = layers_of(r, width);
  std::string data = "# middle of the bar (s), kbit/s piled up, updates/s piled up\n";
  for (std::size_t b = 0; !layers.empty() && b < layers[0].kbps.size(); ++b) {
    data += fixed((static_cast<double>(b) + 0.5) * static_cast<double>(width), 2);
    double pile = 0;
    for (const Layer& l : layers) data += ' ' + fixed(pile += l.kbps[b], 4);
    pile = 0;
    for (const Layer& l : layers) data += ' ' + fixed(pile += l.updates[b], 4);
    data += '\n';
  }
  std::string body = "set multiplot layout 2,1\nset lmargin 12\nset rmargin 26\nset yrange [0:*]\nset boxwidth " +
                     fixed(static_cast<double>(width) * 0.92, 2) + " absolute\n" + time_axis(r);
  body +=
      "set title 'Traffic sent, mean of the peers that are there'\nset xlabel ''\nset ylabel 'on the wire (kbit/s)'\n" +
      piles(layers, 2, true);
  body +=
      "set title 'Entity updates by cause, mean of the peers that are there, each counted once'\nset xlabel 'session "
      "time (s)'\n";
  body += "set ylabel 'updates (1/s)'\n" + piles(layers, 2 + layers.size(), false) + "unset multiplot\n";
  out.push_back({"traffic.dat", data});
  out.push_back(script("traffic", canvas(640), body));
}

// --- who owns which body when

struct Span {
  Tick from = 0;
  Tick until = 0;
  EntityId body = 0;
  PeerId owner = kNoPeer;
};

std::vector<Span> spans_of(const Report& r) {
  std::vector<Span> spans;
  std::map<EntityId, AuthorityChange> open;
  const auto close = [&](const AuthorityChange& c, Tick until) {
    if (c.owner != kNoPeer) spans.push_back({c.tick, until, c.body, c.owner});
  };
  for (const AuthorityChange& c : r.authority) {
    const auto before = open.find(c.body);
    if (before != open.end()) close(before->second, c.tick);
    open[c.body] = c;
  }
  for (const auto& [body, c] : open) close(c, r.authority_until);
  return spans;
}

/// Bars of one owner. Beyond eight owners colours come again, paler; the border is full and shows even a single tick.
std::string owner_bars(PeerId p) {
  constexpr std::array<std::string_view, 4> kDensities{"1", "0.6", "0.35", "0.15"};
  const std::string peer = std::to_string(p);
  const std::string colour = quoted(colour_by_number(p));
  return " using 1:($4==" + peer + "?$3:NaN):1:2:($3-0.4):($3+0.4) with boxxyerror lc rgb " + colour + " fs solid " +
         std::string(kDensities[p / plot::kColours % kDensities.size()]) + " border lc rgb " + colour +
         " title 'peer " + peer + "'";
}

void authority_plot(const Report& r, std::vector<NamedText>& out) {
  const std::vector<Span> spans = spans_of(r);
  std::map<EntityId, std::size_t> rows;
  std::set<PeerId> owners;
  for (const Span& s : spans) {
    rows.emplace(s.body, 0);
    owners.insert(s.owner);
  }
  std::size_t next = 0;
  for (auto& [body, row] : rows) row = next++;
  std::string data = "# from (s), until (s), row, owner, body\n";
  for (const Span& s : spans)
    data += fixed(static_cast<double>(s.from) / kTicksPerSecond, 4) + ' ' +
            fixed(static_cast<double>(s.until) / kTicksPerSecond, 4) + ' ' + std::to_string(rows[s.body]) + ' ' +
            std::to_string(s.owner) + ' ' + std::to_string(s.body) + '\n';
  std::string body =
      "set title 'Which peer owns which body (confirmed world)'\nset lmargin 12\nset rmargin 26\n" + time_axis(r);
  body += "set xlabel 'session time (s)'\nset ylabel 'body (id)'\nset yrange [" +
          std::to_string(std::max<std::size_t>(rows.size(), 1)) + "-0.5:-0.5]\n";
  const std::size_t every = rows.size() / 64 + 1;
  std::string tics;
  for (const auto& [id, row] : rows)
    if (row % every == 0) tics += (tics.empty() ? "'" : ", '") + std::to_string(id) + "' " + std::to_string(row);
  body += "set ytics (" + tics + ")\n";
  if (spans.empty()) body += "unset ytics\nset label 1 'nobody owned a body' at graph 0.5,0.5 center\n";
  std::string curves;
  for (const PeerId p : owners) curves += (curves.empty() ? "plot 'authority.dat'" : ", ''") + owner_bars(p);
  body += (curves.empty() ? "plot NaN notitle" : curves) + "\n";
  out.push_back({"authority.dat", data});
  const auto height = static_cast<int>(std::clamp<std::size_t>(160 + 15 * rows.size(), 300, 1600));
  out.push_back(script("authority", canvas(height), body));
}

}  // namespace

std::vector<std::string> plot_names() {
  return {"inconsistency", "traffic", "authority"};
}

std::vector<NamedText> plot_files(const Report& r) {
  std::vector<NamedText> files;
  inconsistency_plot(r, files);
  traffic_plot(r, files);
  authority_plot(r, files);
  return files;
}

}  // namespace padr::report
