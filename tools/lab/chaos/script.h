#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/model/ids.h"

namespace padr::lab {

/// One thing that happens to a session.
struct ChaosEvent {
  enum class Kind : std::uint8_t {
    kStart,   ///< a process starts and joins
    kLeave,   ///< one says goodbye
    kKill,    ///< one vanishes
    kPause,   ///< one stands still for `span`; by the pick, its machine is suspended
    kDivide,  ///< the network falls into two parts for `span`
    kShape,   ///< all links become another
    kFight,   ///< all avatars are drawn to one place for `span`
    kCut,     ///< what one sends another vanishes for `span`; by the pick, the other way, too
  };
  Kind kind = Kind::kStart;
  Micros at = 0;
  Micros span = 0;
  std::uint64_t pick = 0;  ///< whom, how divided, which link or place: read modulo what there is

  /// Whether the machine is suspended: a quarter of all pauses.
  bool suspends() const { return kind == Kind::kPause && pick >> 62U == 0; }
  /// Whether it wakes up in another network: half of those.
  bool moves() const { return suspends() && (pick >> 61U & 1U) == 0; }
};

struct Behaviour;

/// One of the peers lies, now and then.
struct LyingScript {
  struct Span {
    Micros from;
    Micros to;
  };
  const Behaviour* how = nullptr;
  std::uint64_t pick = 0;   ///< who, which variant of the behaviour, whom it harms
  std::vector<Span> times;  ///< when it lies, in order
};

struct ChaosScript {
  std::uint64_t seed = 0;
  int founders = 2;  ///< peers that begin together
  Micros length = 0;
  std::vector<ChaosEvent> events;  ///< by time
  std::optional<LyingScript> liar;
};

/// Links that a script chooses from; the first is where every script begins.
const std::vector<std::string>& chaos_links();

/// At most `most` peers at once, `least` at least, so far as starts and ends are known.
ChaosScript make_script(std::uint64_t seed, Micros length, int most, int least = 2);

/// The same with links between two peers that fail: in one direction or both, for a while or again and again.
ChaosScript with_cuts(ChaosScript script);

/// The same with a liar among its peers. `how`: its behaviour; null: drawn by the script's seed.
ChaosScript with_liar(ChaosScript script, const Behaviour* how);

/// One line an event.
std::string describe(const ChaosScript& script);

}  // namespace padr::lab
