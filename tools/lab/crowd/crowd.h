#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/crowd/crowd_peer.h"
#include "common/link/link_mesh.h"
#include "common/scenarios/input.h"
#include "tools/lab/crowd/worker_group.h"

namespace padr::lab {

struct CrowdRunConfig {
  crowd::Plane plane;
  Technique technique;
  bool relevance = true;
  link::NetemSpec netem;  ///< of every directed link
  std::uint64_t seed = 1;
  int peers = 4;
  double arrivals = 20;  ///< 1/s: they come one after another
  float room = 144;      ///< m^2 of the plane for every peer
  float stroll = 24;     ///< m: everybody stays in a square of this side, somewhere on the crowd's ground
  /// 1/s: so often everybody gives a body near it a push of 6 m/s, in any direction.
  double shoves = 0;
  int threads = 1;
  std::vector<Vec2> starts{};                          ///< by person, in place of places on the grid
  std::function<Vec2(int person, Tick tick)> drive{};  ///< in place of strolling
};

/// Whole peers of a crowd on one virtual clock and network, every datagram through a shim. They come one after
/// another, with the address of the first; all else they find out from one another. The same configuration gives the
/// same run, to the bit, whatever the number of threads.
class CrowdRun {
 public:
  explicit CrowdRun(CrowdRunConfig config);
  ~CrowdRun();

  /// Some ticks: as many as the links take at least, as nobody can hear in one of them what another says in it.
  void advance();
  /// So many.
  Tick stride() const { return stride_; }
  Tick now() const { return now_; }
  /// A person's machine is suspended: it does nothing, and its clock stands still; or it is no longer.
  void suspend(int person, bool suspended) { persons_[at(person)].suspended = suspended; }
  /// From now on everybody stands where it is.
  void stop_input();

  int persons() const { return static_cast<int>(persons_.size()); }
  const crowd::CrowdPeer& peer(int person) const { return *persons_[at(person)].peer; }
  const Endpoint& place_of(int person) const { return persons_[at(person)].place; }
  /// Who is there, by address; -1: nobody.
  int person_at(const Endpoint& place) const;
  /// Regions that somebody is in.
  std::size_t regions() const { return members_.size(); }
  const std::map<crowd::Region, std::vector<int>>& members() const { return members_; }
  /// Thread time that the peer has taken so far, s.
  double cpu_seconds(int person) const { return persons_[at(person)].cpu; }
  /// From where it strolls to the edge of the crowd's ground, m: beyond that nobody is.
  float from_edge(int person) const { return persons_[at(person)].from_edge; }
  /// Pairs that have had something to tell one another since the last call.
  std::size_t take_links();

  /// Confirmed states of one region and tick that were hashed by one peer and another who are on one side: who agree on
  /// who is in that region.
  std::uint64_t compared() const { return compared_; }
  std::uint64_t different() const { return different_; }
  /// Ticks of all regions that somebody has confirmed; and of these, that were confirmed on several sides: of a region
  /// that two had founded, or that had fallen apart.
  std::uint64_t confirmed() const { return confirmed_; }
  std::uint64_t split() const { return split_; }

 private:
  struct Confirmed {
    crowd::Region region;
    Tick tick;
    std::uint64_t side;
    std::uint64_t hash;
  };
  struct Arrival {
    Micros at;
    std::size_t from;
    wire::Bytes bytes;
  };
  struct Person {
    std::unique_ptr<crowd::CrowdPeer> peer;
    std::unique_ptr<scenarios::InputSource> input;
    Endpoint place;
    std::vector<Arrival> inbox;  ///< by time
    std::vector<Confirmed> confirmed;
    std::set<int> spoken_to;
    double cpu = 0;
    float from_edge = 0;
    std::optional<Vec2> stands;
    Tick comes = 0;  ///< nothing is there before
    bool suspended = false;
    Tick stood_still = 0;  ///< for so long its clock has
  };
  static std::size_t at(int person) { return static_cast<std::size_t>(person); }
  void place(int person);
  Micros time() const { return time_of(now_); }
  static Micros time_of(Tick t) { return tick_start(t) + 1; }
  void work(std::size_t person);
  void work_a_tick(std::size_t person, Micros time);
  Vec2 target_of(std::size_t person, Tick t);
  void shove(std::size_t person, Tick t);
  void compare();
  void note_members();

  CrowdRunConfig config_;
  Tick stride_;
  Tick now_ = 0;
  link::LinkMesh links_;
  std::vector<Person> persons_;
  std::map<Endpoint, int> by_place_;
  std::map<crowd::Region, std::vector<int>> members_;
  std::map<crowd::Region, std::map<Tick, std::map<std::uint64_t, std::uint64_t>>> hashes_;  ///< by side
  std::uint64_t confirmed_ = 0;
  std::uint64_t split_ = 0;
  std::uint64_t compared_ = 0;
  std::uint64_t different_ = 0;
  bool standing_ = false;
  WorkerGroup workers_;
};

}  // namespace padr::lab
