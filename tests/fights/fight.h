#pragma once

#include <string>
#include <vector>

#include "tests/fights/arenas.h"
#include "tools/lab/simulation.h"

namespace padr::test {

/// What happened in a fight.
struct Outcome {
  std::uint64_t confirmed_ticks = 0;
  std::uint64_t differing_worlds = 0;  ///< by hash, which takes in who owns what
  std::uint64_t differing_owners = 0;  ///< bodies, summed over ticks, that two peers' confirmed worlds give to two
  bool rests_alike = false;            ///< in the end every live world is the confirmed one, bit by bit
  bool finite = true;                  ///< every number in every live and confirmed world
  trace::HandOvers hand_overs;
  Tick closest_takeovers =
      0;                     ///< least ticks between two takeovers of the same body; the whole fight if there are none
  Tick longest_dispute = 0;  ///< ticks on end that two peers both hold themselves to be a body's owner
  float fastest_body = 0;    ///< m/s, in any live or confirmed world
  float deepest = 0;         ///< m, overlap of a peer's own avatar and a body in its live world, at its worst
  Tick longest_overlap = 0;  ///< ticks on end that one such overlap was more than 5 cm
  float farthest_push_out = 0;  ///< m in a tick, that a peer's step moved a body beyond what its velocity explains
  /// m in a tick, of the shown position of what is not the viewer's own, and has not become so in the last second, at
  /// its worst: a stride that neither the thing's velocity explains, nor its stride before, nor a change from the one
  /// to the other.
  float largest_foreign_jump = 0;
  std::string largest_jump_where;
  int leaps = 0;        ///< such jumps of about 3 m and more, which convergence does not hide; not among the jumps
  bool fought = false;  ///< every avatar has held a body
};

/// Plays it over links shaped by `netem`.
Outcome fight(const Arena& arena, const std::string& netem, std::uint64_t seed,
              const Technique& technique = technique_by_name("full"));

}  // namespace padr::test
