#pragma once

#include <algorithm>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "common/link/shim.h"
#include "common/replica/replica.h"
#include "common/scenarios/input.h"

namespace padr::bench {

/// Seconds of processor time that this thread has had.
inline double processor_seconds() {
  std::timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

/// Seconds between two looks at the clock with nothing between them; the median of many.
double seconds_of_looking();

/// Seconds of processor time that `work` takes, without what it takes to look at the clock: beside a step of a small
/// world that would count.
inline double seconds_of(const auto& work) {
  static const double looking = seconds_of_looking();
  const double start = processor_seconds();
  work();
  return std::max(0.0, processor_seconds() - start - looking);
}

/// A room as dense as `arena`, 5 m^2 a body, with so many bodies and places to start from.
Scene room(int bodies, int spawns);
/// The same, in which every body moves for ever: nothing slows it down, and what it hits throws it back.
Scene restless_room(int bodies, int spawns);

/// Steps of the whole predicted world that were made again, so far.
inline std::uint64_t whole_replays(const sync::AgreedWorld& a) {
  return a.replayed_steps() - a.locally_replayed_steps();
}

/// Nodes, every directed link through a shim.
struct Mesh {
  /// `input`: as for padr-peer --input, of all of them; `seed`: of the inputs and the network.
  Mesh(const Scene& scene, int peers, const std::string& netem, const std::string& input, std::uint64_t seed);

  std::vector<std::unique_ptr<node::Replica>> nodes;
  std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
  std::vector<std::vector<std::unique_ptr<link::Shim>>> shims;  ///< from, to
};

/// A mesh in lock step; the first one's frames are measured.
class Party {
 public:
  Party(const Scene& scene, int peers, const std::string& netem, const std::string& input, std::uint64_t seed = 1)
      : mesh_(scene, peers, netem, input, seed) {}

  struct Frame {
    double seconds = 0;             ///< all datagrams of one tick, the step, and what goes out, encoded
    std::uint64_t allocations = 0;  ///< meanwhile
    std::size_t datagrams = 0;      ///< that came in
  };
  /// One tick of all of them; the first one's frame.
  Frame tick();

  const node::Replica& first() const { return *mesh_.nodes[0]; }

 private:
  std::vector<std::vector<std::byte>> arrived(std::size_t at);
  Frame frame(std::size_t p);

  Tick now_ = 0;
  Mesh mesh_;
};

}  // namespace padr::bench
