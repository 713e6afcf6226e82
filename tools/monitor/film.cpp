#include "tools/monitor/film.h"

#include <algorithm>
#include <array>

#include "tools/monitor/words.h"

namespace padr::monitor {
namespace {

/// Of all views of a film.
constexpr double kMostBytes = 400e6;
/// After a jump, what is shown is at most so old.
constexpr Tick kLookBack = 5 * kTicksPerSecond;
constexpr Tick kTableEvery = kTicksPerSecond / 4;
/// An inconsistency is repeated so long while none is measured.
constexpr Tick kHeldFor = 2 * kTicksPerSecond;

std::optional<trace::InconsistencyPoint> newest_until(const trace::InconsistencySeries& errors, Tick tick) {
  const auto after = std::upper_bound(errors.begin(), errors.end(), tick,
                                      [](Tick t, const trace::InconsistencyPoint& p) { return t < p.tick; });
  if (after == errors.begin() || std::prev(after)->tick < tick - kHeldFor) return std::nullopt;
  return *std::prev(after);
}

}  // namespace

Tick sample_for(Tick ticks, std::size_t views, std::size_t entities) {
  constexpr std::array<Tick, 12> kSamples{1, 2, 3, 4, 5, 6, 10, 12, 15, 20, 30, 60};
  const double moment = static_cast<double>(views) * (64.0 + 16.0 * static_cast<double>(entities));
  for (const Tick s : kSamples)
    if (moment * ticks / s <= kMostBytes) return s;
  return kSamples.back();
}

FilmMaker::FilmMaker(std::unique_ptr<ObservedSession> session, Tick sample, Tick ticks)
    : table_every_(std::max(kTableEvery, ticks / kTables)) {
  film_.session = std::move(session);
  film_.sample = sample;
  film_.scene = scene_text(*film_.session);
}

void FilmMaker::take(Tick tick) {
  ObservedSession& s = *film_.session;
  const Micros now = time_of(tick);
  s.advance(now);
  Film::Moment m{tick, {}};
  constexpr unsigned kAll = (1U << kWhiches) - 1;
  for (const ViewSource::View& v : s.views(kAll, serial_)) {
    const std::string& b = *v.bytes;
    m.pictures.push_back({static_cast<PeerId>(b[1]), static_cast<Which>(b[2]), v.bytes});
  }
  serial_ = s.serial();
  if (!m.pictures.empty()) film_.moments.push_back(std::move(m));
  if (!film_.tables.empty() && tick - film_.tables.back().tick < table_every_) return;
  Film::Table t{tick,
                peers_text(
                    s, 0, [](PeerId) { return std::string_view("no"); }, now),
                s.sample(now)};
  if (!t.series.peers.empty()) film_.series.push_back(t.series);
  for (const auto& [slot, point] : s.newest_measured()) film_.errors[slot].push_back(point);
  film_.tables.push_back(std::move(t));
}

Film FilmMaker::finish() {
  // A tick may be confirmed after a later one.
  for (auto& [slot, errors] : film_.errors)
    std::sort(errors.begin(), errors.end(), [](const auto& a, const auto& b) { return a.tick < b.tick; });
  return std::move(film_);
}

void Screen::go_to(Tick tick) {
  if (tick < tick_) {
    pictures_.clear();
    const auto& all = film_.moments;
    const auto from = std::lower_bound(all.begin(), all.end(), tick - kLookBack,
                                       [](const Film::Moment& m, Tick t) { return m.tick < t; });
    next_ = static_cast<std::size_t>(from - all.begin());
  }
  tick_ = tick;
  while (next_ < film_.moments.size() && film_.moments[next_].tick <= tick) put(film_.moments[next_++]);
}

void Screen::put(const Film::Moment& m) {
  for (const Film::Picture& p : m.pictures) pictures_[{p.slot, p.which}] = {++serial_, p.bytes};
}

std::vector<ViewSource::View> Screen::views(unsigned views, std::uint64_t since) {
  std::vector<View> out;
  for (const auto& [what, view] : pictures_)
    if ((views & 1U << static_cast<unsigned>(what.second)) != 0 && view.serial > since) out.push_back(view);
  return out;
}

const Film::Table* Screen::table() const {
  const auto after = std::upper_bound(film_.tables.begin(), film_.tables.end(), tick_,
                                      [](Tick t, const Film::Table& table) { return t < table.tick; });
  return after == film_.tables.begin() ? nullptr : &*std::prev(after);
}

std::string Screen::series() const {
  const Film::Table* const t = table();
  if (t == nullptr || t->series.peers.empty()) return "";
  SeriesPoint point = t->series;
  for (PeerPoint& p : point.peers) {
    const auto errors = film_.errors.find(p.slot);
    p.inconsistency = errors == film_.errors.end() ? std::nullopt : newest_until(errors->second, tick_);
  }
  return series_text(point);
}

}  // namespace padr::monitor
