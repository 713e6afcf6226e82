#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "common/model/ids.h"
#include "common/model/vec.h"

namespace padr::trace {

/// Combined inconsistency of one view over the ticks measured, in metres (area: metre seconds).
struct Inconsistency {
  std::uint64_t ticks = 0;
  double mean_m = 0;
  double avatar_mean_m = 0;  ///< the part of avatars
  double body_mean_m = 0;    ///< the part of bodies
  double p95_m = 0;
  double p99_m = 0;
  double peak_m = 0;
  double area_ms = 0;
  double final_m = 0;
  double shown_mean_m = 0;  ///< of the shown positions, convergence included
  double shown_peak_m = 0;
};

/// One tick's combined inconsistency of one peer's view.
struct InconsistencyPoint {
  Tick tick = 0;
  float avatars_m = 0;
  float bodies_m = 0;
  float shown_m = 0;
  float combined() const { return avatars_m + bodies_m; }
};

/// What one peer's view was off by, tick by tick.
using InconsistencySeries = std::vector<InconsistencyPoint>;

/// Where every entity is in one peer's view at one tick.
struct View {
  std::vector<Vec2> live;   ///< m, by entity id
  std::vector<Vec2> shown;  ///< m
  /// Bodies that nobody owns play out here alone: see plays_unowned_alone.
  bool unowned_alone = false;
};

/// The agreed word on one tick.
struct Truth {
  std::vector<PeerId> owner;  ///< by entity id; kNoPeer: nobody
  std::vector<bool> present;  ///< by entity id
  std::vector<Vec2> agreed;   ///< m, positions in the confirmed world
};

/// What one view is off by at a tick: the sum over entities that are there of the distance to where their authority has
/// them. `by_slot`: everybody's view of the same tick by slot, null where there is none. An entity whose authority has
/// no view is where it is agreed to be, and so is a body that nobody owns in the view of a peer that takes it from the
/// agreed world. In the view of a peer that plays such bodies out alone there is no word to hold against: it is off by
/// the mean of its distances to the live places in all other views of peers that are there; with two peers, by how far
/// the two worlds are apart, as the paper measures it.
InconsistencyPoint inconsistency_of(const View& view, const std::vector<const View*>& by_slot, const Truth& truth,
                                    int bodies, Tick tick);

/// Combined inconsistency as all programs mean it: per tick, the sum over entities of the distance between a peer's
/// view and the view of the entity's authority at the same session tick; for a body that nobody owns, the agreed world
/// or the other views, see inconsistency_of.
/// Who owned what is known once the tick is confirmed; views wait for that.
class InconsistencyMeter {
 public:
  /// Entities 0 .. bodies-1 are bodies, bodies + p the avatar of peer p. Views are of peers 0 .. peers-1.
  InconsistencyMeter(int peers, int bodies);
  /// Views are of viewers 0, 1, ..., who sit where `slots` says: several may sit in a slot, one after the other. Should
  /// two be there at a time, the later one's view is the slot's.
  InconsistencyMeter(std::vector<PeerId> slots, int bodies);

  void view(std::size_t viewer, Tick tick, const View& v);
  /// The viewer has no view of ticks before this one. To be said before any view is.
  void came(std::size_t viewer, Tick from) { came_at_[viewer] = from; }
  /// The viewer has no view of ticks from this one on: it has left.
  void gone(std::size_t viewer, Tick from);
  void truth(Tick tick, const Truth& t);

  Inconsistency result(std::size_t viewer) const;
  /// The mean over peers, ticks weighted alike; peaks are the highest of any.
  Inconsistency overall() const;
  const std::vector<InconsistencyPoint>& series(std::size_t viewer) const { return series_[viewer]; }

 private:
  struct Pending {
    std::vector<View> views;  ///< by viewer
    std::vector<char> there;  ///< by viewer: whether that view is
    bool has_truth = false;
    Truth truth;
  };
  using PendingTicks = std::map<Tick, Pending>;
  PendingTicks::iterator pending(Tick tick);
  void settle(PendingTicks::iterator at);
  bool ready(Tick tick, const Pending& p) const;
  void measure(Tick tick, const Pending& p);

  int bodies_;
  std::vector<PeerId> slots_;  ///< by viewer
  std::vector<Tick> came_at_;
  std::vector<Tick> gone_from_;
  PendingTicks pending_;
  std::vector<PendingTicks::node_type> spare_;  ///< with the memory of what has been measured
  std::vector<const View*> by_slot_;
  std::vector<std::vector<InconsistencyPoint>> series_;
};

/// Summary of a series.
Inconsistency summarize(const InconsistencySeries& series);
/// The mean over several peers' series, ticks weighted alike; peaks are the highest of any.
Inconsistency summarize_all(const std::vector<InconsistencySeries>& series);

/// Below this an inconsistency is noise: Box2D's linear slop, in metres.
inline constexpr double kNoiseMetres = 0.005;

}  // namespace padr::trace
