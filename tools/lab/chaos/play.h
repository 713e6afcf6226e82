#pragma once

#include <functional>
#include <optional>
#include <string>

#include "common/model/scene.h"
#include "common/model/technique.h"
#include "common/replica/recorded_replica.h"
#include "common/wire/sealed.h"
#include "tools/lab/chaos/script.h"
#include "tools/lab/testbed/harm.h"

namespace padr::lab {

struct ChaosOutcome {
  std::string violation;           ///< empty: none
  std::uint64_t compared = 0;      ///< confirmed hashes, in pairs
  int peers = 0;                   ///< that ever started
  int incarnations = 0;            ///< begun by them, returns included
  double slowest_join = 0;         ///< s, from the start of a process to its first tick
  Harm harm;                       ///< to the honest
  Micros differed = 0;             ///< longest time for which two honest peers confirmed different worlds, us
  std::uint64_t lies = 0;          ///< datagrams that the liar changed, added or withheld
  bool led_by_liar = false;        ///< the liar took itself for the coordinator at some time while it lied
  std::vector<std::string> story;  ///< notes of all peers, if asked for
};

struct ChaosPlay {
  Scene scene;
  Technique technique;
  int slots = 12;
  wire::SealMode seal = wire::SealMode::kNone;  ///< not kNone: the sessions have a key
  Micros quiet = 20 * kMicrosPerSecond;         ///< after the script, all healed
  Micros differ = 30 * kMicrosPerSecond;        ///< where one lies: longest time for which confirmed worlds may differ
  HarmBounds bounds;                            ///< where one lies
  bool story = false;
  bool spectators = false;  ///< some of those who come later have no avatar, and some founders of three or more
  /// As in VirtualNetworkConfig.
  std::function<std::optional<node::RecordedReplica::Recording>(int person, int incarnation)> recording;
};

/// Plays a script to its end, and a while of quiet, or to the first violation.
ChaosOutcome play(const ChaosPlay& how, const ChaosScript& script);

}  // namespace padr::lab
