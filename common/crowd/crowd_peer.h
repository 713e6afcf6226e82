#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/crowd/customs.h"
#include "common/crowd/plane.h"
#include "common/node/participant.h"

namespace padr::crowd {

struct CrowdConfig {
  Plane plane;
  Technique technique;
  bool relevance = true;  ///< thresholds rise where nobody is near
  std::uint64_t fingerprint = 0;
  std::uint64_t seed = 0;  ///< of this peer's nonces; no two peers' are the same
  Vec2 start;              ///< m, where its avatar is first
  std::function<void(Region, const sync::FoldState&, std::uint64_t hash)> on_confirmed{};
};

struct CrowdStats {
  std::uint64_t handovers = 0;  ///< its avatar has gone home in another region
  std::uint64_t entered = 0;    ///< regions come into, founded ones included
  std::uint64_t founded = 0;
  std::uint64_t failed = 0;      ///< attempts to come in
  std::uint64_t late = 0;        ///< ticks with the avatar a metre inside a region that it is not in yet
  std::uint64_t node_ticks = 0;  ///< steps of all its regions
  std::uint64_t datagrams = 0;
  std::uint64_t wire_bytes = 0;  ///< IP and UDP headers included
};

/// A whole peer of a crowd but for its clock, socket, input, and the finding of others: a Participant in every region
/// that it is in. Pure, as Participant is.
class CrowdPeer {
 public:
  explicit CrowdPeer(const CrowdConfig& config);

  /// Regions that it wants to come into and has not been told of.
  std::vector<Region> asks(Micros local) const;
  /// Somebody who is in the region, or, for lack of anybody, that it is this peer's to found.
  void told(Region r, const std::optional<Endpoint>& member, Micros local);

  /// As in Node, in a region where it plays.
  void push(Region r, EntityId body, Vec2 velocity);
  void receive(const Endpoint& from, std::span<const std::byte> datagram, Micros local);
  /// Everything that is due. `target`: where the avatar is driven in a tick, m.
  void turn(const std::function<Vec2(Tick)>& target, Micros local);
  std::vector<node::Parcel> take_outgoing();

  /// Plays: is at home somewhere.
  bool playing() const { return home_.has_value(); }
  Region home() const { return *home_; }
  Tick now() const { return places_.at(*home_).peer->node().now(); }
  const BodyState& avatar() const { return avatar_; }
  /// The regions where it is a member and stays, with their participants.
  std::vector<Post> posts() const;
  const CrowdStats& stats() const { return stats_; }
  const Customs& customs() const { return customs_; }
  std::uint64_t updates() const;

 private:
  struct Place {
    std::unique_ptr<node::Participant> peer;
    bool leaving = false;
    Micros left = 0;
  };
  void tick(Vec2 target, Micros local);
  void lead(Region r, Place& place, const BodyState& before, Vec2 target, Micros local);
  bool drives(const Place& place) const;
  void go_home();
  void reconsider(Micros local);
  static void say_whether_going(Place& place, bool go);
  static bool may_leave(const node::Node& n);
  void end_places(Micros local);
  void adapt_thresholds();
  void retire(Place& place);

  CrowdConfig config_;
  std::map<Region, Place> places_;
  std::map<Region, Micros> retry_;  ///< not to be asked for before
  std::vector<Region> wanted_;
  std::optional<Region> home_;
  BodyState avatar_;
  Customs customs_;
  CrowdStats stats_;
  std::vector<node::Parcel> last_words_;  ///< of regions it has left, not yet taken
  std::uint64_t past_updates_ = 0;        ///< of regions it has left
  std::uint64_t attempts_ = 0;
};

/// How many times the usual threshold an avatar's may be in a region where it is a guest, by its distance from the
/// nearest avatar at home there or body that moves: once within 4 m, once more for every 2 m beyond, 8 times at most.
float coarseness_of(const Plane& plane, Region r, const node::Node& n);

}  // namespace padr::crowd
