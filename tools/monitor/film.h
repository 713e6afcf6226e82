#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tools/monitor/observed_session.h"
#include "tools/monitor/view_source.h"

namespace padr::monitor {

/// A recording, ready to be shown from any tick on: what a session that is followed live would have shown.
struct Film {
  struct Picture {
    PeerId slot = kNobody;
    Which which = Which::kShown;
    Shared bytes;
  };
  struct Moment {
    Tick tick = 0;
    std::vector<Picture> pictures;  ///< what is new
  };
  struct Table {
    Tick tick = 0;
    std::string peers;   ///< the message
    SeriesPoint series;  ///< without peers: none
  };

  std::unique_ptr<ObservedSession> session;  ///< as it was in the end
  std::string scene;                         ///< the message
  std::vector<Moment> moments;               ///< by ascending tick
  std::vector<Table> tables;                 ///< likewise
  std::deque<SeriesPoint> series;
  /// By slot, by ascending tick: known when a tick is confirmed, which is later.
  std::map<PeerId, trace::InconsistencySeries> errors;
  Tick sample = 1;  ///< ticks between moments

  Tick first() const { return moments.empty() ? 0 : moments.front().tick; }
  Tick last() const { return moments.empty() ? 0 : moments.back().tick; }
};

/// How many ticks there are to be between two moments, so that views of so many entities, so many at a time, stay
/// below a bound however long the recording is. Divides 60.
Tick sample_for(Tick ticks, std::size_t views, std::size_t entities);

/// Follows a session and makes the film of it.
class FilmMaker {
 public:
  FilmMaker(std::unique_ptr<ObservedSession> session, Tick sample, Tick ticks);

  ObservedSession& session() { return *film_.session; }
  /// All has been told of the tick: it becomes a moment if it is one.
  void take(Tick tick);
  Film finish();

  static constexpr Tick kTables = 10'000;  ///< at most
  static Micros time_of(Tick t) { return tick_start(t); }

 private:
  Film film_;
  Tick table_every_;
  std::uint64_t serial_ = 0;
};

/// Where a film is shown: the pictures of one moment.
class Screen : public ViewSource {
 public:
  explicit Screen(const Film& film) : film_(film) {}

  /// Forwards or backwards.
  void go_to(Tick tick);

  std::uint64_t serial() const override { return serial_; }
  std::vector<View> views(unsigned views, std::uint64_t since) override;
  /// The newest table at that moment; null if there is none yet.
  const Film::Table* table() const;
  /// The series message of that table, with the inconsistency of this very moment, or the newest before it; empty if
  /// there is none.
  std::string series() const;

 private:
  void put(const Film::Moment& m);

  const Film& film_;
  std::size_t next_ = 0;  ///< moment that has not been put
  Tick tick_ = 0;
  std::uint64_t serial_ = 0;
  std::map<std::pair<PeerId, Which>, View> pictures_;
};

}  // namespace padr::monitor
