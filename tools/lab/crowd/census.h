#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "common/sync/updates.h"
#include "tools/lab/crowd/crowd.h"

namespace padr::lab {

/// How right peers of a crowd have what is near them, over the ticks that are looked at.
class Census {
 public:
  /// Of avatars and bodies within `near` metres of one's own avatar.
  explicit Census(float near) : near_(near) {}

  void look(const CrowdRun& run);

  /// m: mean over peers and looks of the sum over the avatars, or the bodies, near a peer, of the distance between
  /// where it has them and where their owners have them.
  double avatars() const { return mean(avatar_error_, looks_); }
  double bodies() const { return mean(body_error_, looks_); }
  /// m: mean over the avatars that were near somebody.
  double per_avatar() const { return mean(avatar_error_, avatars_); }
  /// Avatars near a peer, on average.
  double neighbours() const { return mean(static_cast<double>(avatars_), looks_); }
  /// Share of the avatars near somebody that it does not have at all, 0 .. 1.
  double unseen() const { return mean(static_cast<double>(unseen_), avatars_ + unseen_); }
  /// Means over peers and looks.
  double regions() const { return mean(static_cast<double>(regions_), looks_); }

 private:
  struct Truth {
    Vec2 position;
    std::uint32_t crossings = 0;
  };
  static double mean(double sum, std::uint64_t n) { return n == 0 ? 0 : sum / static_cast<double>(n); }
  void find_truth(const CrowdRun& run);
  void look_at_avatars(const CrowdRun& run, int person);
  void look_at_bodies(const CrowdRun& run, int person);

  float near_;
  std::map<std::pair<int, int>, std::vector<int>> grid_;  ///< persons, by square of `near_`
  std::map<sync::BodyName, Truth> bodies_;                ///< that somebody owns
  double avatar_error_ = 0;
  double body_error_ = 0;
  std::uint64_t avatars_ = 0;
  std::uint64_t unseen_ = 0;
  std::uint64_t regions_ = 0;
  std::uint64_t looks_ = 0;
};

}  // namespace padr::lab
