#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tools/lab/testbed/virtual_network.h"

namespace padr::lab {

/// What must hold whatever happens, watched all along.
///
/// Confirmed worlds: of two peers that both took the other for a member when they confirmed a tick, the hashes of that
/// tick are the same. (Two sides of a partition go different ways, and whoever has been killed may have confirmed
/// updates of its own that nobody ever got: neither takes the other for a member any more.)
class Judge {
 public:
  explicit Judge(VirtualNetwork& network);

  /// This person lies: it is nobody's peer, and what others drop may be its doing.
  void expect_lies_of(int person) { liars_.insert(person); }
  const std::set<int>& liars() const { return liars_; }
  /// Confirmed worlds of two peers may differ for at most this long, us, until they are mended. 0: not at all.
  void tolerate_differences(Micros longest) { tolerated_ = longest; }
  /// Longest time for which the confirmed worlds of two peers differed, us.
  Micros longest_difference() const { return longest_difference_; }
  /// The first violation, in one line; empty if there is none.
  const std::string& violation() const { return violation_; }
  std::uint64_t compared() const { return compared_; }
  /// At the end, when all has been quiet for a while: everybody who runs is in one session, has everybody's updates,
  /// and the same confirmed world. Where somebody lies, those whom it alone has let in, into a session of its own, know
  /// of no others, and nobody knows of them: they have to agree among themselves.
  void final_check();
  /// How many such there were.
  int held_apart() const { return held_apart_; }

 private:
  using Seat = std::pair<PeerId, std::uint32_t>;  ///< slot, incarnation
  struct Record {
    int person;
    std::uint64_t hash;
    Seat self;
    std::vector<Seat> others;
  };
  struct Heard {
    int person;
    int incarnation;
    Tick tick;
    std::uint64_t hash;
  };
  struct Difference {
    Micros since;
    Micros seen;
  };
  void confirmed(int person, int incarnation, const sync::FoldState& s, std::uint64_t hash);
  void turn(int person);
  void check_drops(int person);
  void check_kept(int person, const node::Replica& n);
  void compare(Tick t, Record r);
  void judge_pair(Tick t, const Record& a, const Record& b);
  bool is_liars(const node::Replica& seen_by, PeerId slot) const;
  std::vector<std::vector<int>> parts_that_know_of_each_other(std::vector<int> all) const;
  void check_part(const std::vector<int>& all);
  void check_members(int person, const std::vector<int>& all);
  void blame(const std::string& what);

  VirtualNetwork& network_;
  std::vector<Heard> heard_;
  std::map<Tick, std::vector<Record>> records_;
  std::set<int> liars_;
  Micros tolerated_ = 0;
  Micros longest_difference_ = 0;
  std::map<std::pair<int, int>, Difference> differences_;  ///< by persons
  std::map<int, Tick> keeps_too_many_;                     ///< by person, since when
  std::uint64_t compared_ = 0;
  int held_apart_ = 0;
  std::string violation_;
};

}  // namespace padr::lab
