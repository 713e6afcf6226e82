#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "common/replica/replica.h"

namespace padr::peer {

/// What a peer has come to know in all its incarnations: confirmed worlds, and who came and went.
class History {
 public:
  struct Checkpoint {
    Tick tick = -1;
    std::uint64_t hash = 0;
  };
  struct Incarnation {
    PeerId peer = kNoPeer;
    std::uint32_t incarnation = 0;
    Tick came = -1;            ///< first tick played; -1: has not come in
    Tick confirmed_from = -1;  ///< of its agreed world, with which it began
    Checkpoint confirmed;      ///< newest
  };

  /// A replica is made for this incarnation, maybe not for the first time.
  void begin(int incarnation);
  void confirm(int incarnation, Tick tick, std::uint64_t hash);
  /// The incarnation plays from this tick on.
  void play(int which, PeerId peer, std::uint32_t incarnation, Tick tick);
  void change(const node::MemberChange& c);

  const std::vector<Incarnation>& incarnations() const { return incarnations_; }
  Checkpoint confirmed(int incarnation) const;
  /// Hashes of the last incarnation's confirmed ticks that are whole seconds, the last kCheckpointsKept of them: those
  /// are what it has in common with the others. An earlier one may have been given up, or of another session.
  const std::map<Tick, std::uint64_t>& checkpoints() const { return checkpoints_; }

  // Others, each once in each of their incarnations:
  std::uint64_t came() const { return seen_[0].size(); }
  std::uint64_t left() const { return seen_[1].size(); }
  std::uint64_t removed() const { return seen_[2].size(); }

  static constexpr std::size_t kCheckpointsKept = 3600;

 private:
  std::vector<Incarnation> incarnations_;
  std::vector<std::map<Tick, std::uint64_t>> pending_;  ///< by incarnation, until it plays
  std::map<Tick, std::uint64_t> checkpoints_;
  std::array<std::set<std::pair<PeerId, std::uint32_t>>, 3> seen_;  ///< by kind of change
};

}  // namespace padr::peer
