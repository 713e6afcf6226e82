#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "common/model/ids.h"
#include "tools/lab/alternatives/quantised.h"

namespace padr::lab::alternatives {

/// A body in a snapshot.
struct Piece {
  bool mine = false;           ///< the sender owns it; if not, the rest is as in the scenario
  std::uint16_t sequence = 0;  ///< of the claim
  bool held = false;
  Quantised state;
  friend bool operator==(const Piece&, const Piece&) = default;
};

/// A snapshot: what one peer owns at one tick.
struct Content {
  Tick tick = 0;
  Quantised avatar;
  std::vector<Piece> bodies;
  bool same_as(const Content& o) const { return avatar == o.avatar && bodies == o.bodies; }
};

/// The snapshots of one sender on their way to being shown, and the delay at which they are.
///
/// The delay adapts to the link: the age at which snapshots came in the last seconds at worst, plus the interval to the
/// next one, so that there are always two around the time shown; plus one more interval once a hundredth of them was
/// lost, and two from a fifth on. It grows at once and shrinks by a tick each second.
class Playout {
 public:
  /// `interval`: ticks between snapshots.
  explicit Playout(Tick interval = 1) : interval_(interval), delay_(interval) {}

  /// A snapshot that has come when the receiver was about to make tick `now`. `number` counts the sender's datagrams
  /// to this receiver, so that a pause is told from a loss.
  void add(const Content& c, std::uint8_t number, Tick now);
  /// Once per tick, before showing.
  void advance(Tick now);

  Tick delay() const { return delay_; }

  /// Around the time shown: `b` may be the same as `a`, beyond which there is nothing yet. Nothing before the first.
  struct Moment {
    const Content* before = nullptr;  ///< the one before a, for the curve through them, or null
    const Content* a = nullptr;
    const Content* b = nullptr;
    const Content* after = nullptr;  ///< likewise
    Tick at = 0;
  };
  std::optional<Moment> moment(Tick now) const;

 private:
  struct Age {
    Tick came = 0;
    Tick age = 0;
  };
  void count(std::uint8_t number);
  Tick wanted() const;

  Tick interval_;
  Tick delay_;
  Tick shrunk_ = 0;
  std::deque<Content> contents_;  ///< by tick
  std::deque<Age> ages_;
  std::deque<bool> arrived_;  ///< of the last datagrams
  std::uint8_t number_ = 0;
  bool heard_ = false;
};

}  // namespace padr::lab::alternatives
