#pragma once

#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/model/scene.h"
#include "common/sync/transfer.h"
#include "tools/capture/session_log.h"

namespace padr::capture {

/// Which updates of a session count, and up to where an incarnation's log is known: what peers agree on between
/// themselves, told afterwards from the packets.
///
/// An incarnation is removed by an update of the coordinator, which says from which number on its updates never
/// happened. After a partition two sides have removed each other. Whose removal stands is told by who was heard
/// longest: the losing side gives its incarnations up.
class CountedUpdates {
 public:
  static constexpr Tick kForever = std::numeric_limits<Tick>::max();

  /// Updates that no receiver would believe are left out. `session_log` must outlive it.
  CountedUpdates(const SessionLog& session_log, const Scene& scene, int slots);

  /// Where the fold begins: peers 0 .. peers-1 at tick 0, or at a transfer. Call one of these first.
  void begin(int peers);
  void begin(const sync::Transfer& transfer);

  /// What counts at this tick, by ascending peer.
  std::vector<sync::Bundle> at(Tick tick) const;
  /// The last tick up to which all of an incarnation's updates are known; kForever if it has ended and they all are.
  Tick complete(const Incarnation& who) const;
  /// Why it is not complete beyond, for people. `missing`: an update is missing that was promised.
  std::string lacks(const Incarnation& who, bool& missing) const;
  /// Whether a hash that this incarnation told of this tick is of the world that stands.
  bool counts(const SessionLog::Check& check) const;
  /// Updates that are left out because nobody would believe them.
  std::uint64_t unbelievable() const { return unbelievable_; }

 private:
  struct Span {
    std::uint32_t first = 0;
    std::uint32_t end = std::numeric_limits<std::uint32_t>::max();  ///< its updates from here on do not count
    std::uint32_t have = 0;                                         ///< all from `first` below this are known
    Tick complete = -1;
    Tick other_world = kForever;  ///< from this tick on what it says is of a world that was given up
  };
  struct Removal {
    Incarnation by;
    std::uint32_t index = 0;  ///< of the coordinator's update
    std::int64_t heard_ns = 0;
    Incarnation who;
    std::uint32_t count = 0;
  };

  const sync::Bundle* find(const Incarnation& who, std::uint32_t index) const;
  std::vector<Removal> removals() const;
  void settle();
  void admit();
  void measure(const Incarnation& who, Span& span);

  const SessionLog& session_log_;
  const Scene& scene_;
  int slots_;
  std::map<std::pair<PeerId, std::uint32_t>, sync::Bundle> retold_;  ///< and what a transfer brings along
  std::map<Incarnation, std::uint32_t> ends_;
  std::map<Incarnation, Span> spans_;
  std::map<Tick, std::map<PeerId, const sync::Bundle*>> by_tick_;
  std::uint64_t unbelievable_ = 0;
};

}  // namespace padr::capture
