#pragma once

#include <string>

#include "common/model/scene.h"
#include "common/model/technique.h"
#include "common/wire/sealed.h"
#include "tools/lab/chaos/script.h"

namespace padr::lab {

struct ChaosOutcome {
  std::string violation;           ///< empty: none
  std::uint64_t compared = 0;      ///< confirmed hashes, in pairs
  int peers = 0;                   ///< that ever started
  int incarnations = 0;            ///< begun by them, returns included
  double slowest_join = 0;         ///< s, from the start of a process to its first tick
  std::vector<std::string> story;  ///< notes of all peers, if asked for
};

struct ChaosPlay {
  Scene scene;
  Technique technique;
  int slots = 12;
  wire::SealMode seal = wire::SealMode::kNone;  ///< not kNone: the sessions have a key
  Micros quiet = 20 * kMicrosPerSecond;         ///< after the script, all healed
  bool story = false;
};

/// Plays a script to its end, and a while of quiet, or to the first violation.
ChaosOutcome play(const ChaosPlay& how, const ChaosScript& script);

}  // namespace padr::lab
