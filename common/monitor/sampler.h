#pragma once

#include <cstdint>
#include <vector>

#include "common/monitor/telemetry.h"
#include "common/replica/replica.h"

namespace padr::monitor {

/// Makes what a monitor is told out of a replica: the running one of a peer, or one that a trace is replayed with. It
/// changes nothing in the replica.
class Sampler {
 public:
  /// `rate`: frames a second, 1 .. 60.
  Sampler(int rate, Detail detail) : rate_(rate), detail_(detail) {}

  /// A replica begins to be looked at, the first or another one. Says so with an event.
  void begin(const node::Replica& replica, const std::string& text);
  /// After each of its steps: what has changed since becomes events.
  void observe(const node::Replica& replica);
  /// Somebody has come or gone.
  void observe(const node::MemberChange& change);
  /// What only the caller knows of; the number is filled in.
  void say(Event event);
  /// Those since the last call, oldest first.
  std::vector<Event> take_events();

  /// Whether there is to be a frame of tick t, and later an agreed world. Peers of the same rate have theirs of the
  /// same ticks.
  bool due(Tick t) const;
  /// After at least one step of the replica. `driven` is the caller's to fill in. Keeps what memory `out` has.
  void frame(const node::Replica& replica, Vec2 target, Frame& out) const;
  /// Of a confirmed state, as a replica hands it to its sink.
  static void agreed(const sync::FoldState& confirmed, std::uint64_t hash, bool authority, Agreed& out);
  /// All that a replica knows; what only the caller knows is left as it is. Counters are the replica's, of this
  /// incarnation.
  static Status status(const node::Replica& replica);

  int rate() const { return rate_; }
  Detail detail() const { return detail_; }

 private:
  void observe_body(const node::Replica& replica, EntityId b);

  int rate_;
  Detail detail_;
  std::vector<PeerId> owner_;  ///< by body, as last seen
  std::vector<char> held_;     ///< by body: by the own avatar
  bool differed_ = false;
  std::uint32_t number_ = 0;
  std::vector<Event> events_;
};

}  // namespace padr::monitor
