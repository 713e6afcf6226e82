#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tools/lab/testbed/virtual_network.h"

namespace padr::lab {

/// What honest peers suffered, longest times in us. Times in which a peer stood still itself do not count.
struct Harm {
  Micros unconfirmed = 0;  ///< one confirmed nothing new
  Micros out = 0;          ///< one that had been in was not in the largest group of the honest who know of one another
  Micros stalled = 0;      ///< one's live world made no step
  int evicted = 0;         ///< times that one was declared gone
  int evicted_reachable = 0;  ///< of them, though it and one of those who did it were in reach of all others lately
  int begun_anew = 0;         ///< incarnations begun after the first
  int kept_out = 0;           ///< joiners that gave up, were refused, or got into a session of the liar's own
};

/// How long harm may last, us; whatever lasts longer is a violation.
struct HarmBounds {
  Micros unconfirmed = 30 * kMicrosPerSecond;
  Micros out = 30 * kMicrosPerSecond;
  Micros stalled = kMicrosPerSecond;
};

/// Watches the honest peers of a session.
class HarmMeter {
 public:
  /// Both must outlive it. `liars` may grow.
  HarmMeter(const VirtualNetwork& network, const std::set<int>& liars, const HarmBounds& bounds = {});

  /// To be called every kEvery of the network's time.
  void look();
  static constexpr Micros kEvery = 100'000;

  const Harm& harm() const { return harm_; }
  /// The first violation, in one line; empty if there is none.
  const std::string& violation() const { return violation_; }

 private:
  using Seat = std::pair<PeerId, std::uint32_t>;  ///< slot, incarnation
  struct Watched {
    int incarnation = -1;
    bool evicted = false;
    bool was_in = false;
    bool ended = false;
    Tick confirmed = -1;
    Micros confirmed_at = 0;
    Micros in_at = 0;
    Tick now = -1;
    Micros stepped_at = 0;
    Micros unreachable_at = -kMicrosPerSecond * 1000;
  };
  bool honest(int person) const { return !liars_.contains(person); }
  bool plays(int person) const;
  bool know_each_other(int a, int b) const;
  std::set<int> largest_groups() const;
  bool is_reachable(int person) const;
  /// Within the last kLately.
  bool was_reachable(int person);
  std::vector<int> evictors_of(int person) const;
  void look_at(int person, bool in);
  void look_for_eviction(int person, Watched& w);
  void look_at_ended(int person);
  void look_for_bans(int person);
  void note(Micros lasted, Micros& longest, Micros bound, const std::string& what);
  void blame(const std::string& what);

  const VirtualNetwork& network_;
  const std::set<int>& liars_;
  HarmBounds bounds_;
  Harm harm_;
  std::map<int, Watched> watched_;
  std::string violation_;
};

}  // namespace padr::lab
