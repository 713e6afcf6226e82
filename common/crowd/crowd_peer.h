#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/crowd/finder.h"
#include "common/crowd/handover.h"
#include "common/crowd/regions.h"
#include "common/participant/participant.h"

namespace padr::crowd {

struct CrowdConfig {
  Plane plane;
  Technique technique;
  bool relevance = true;  ///< thresholds rise where nobody is near
  std::uint64_t fingerprint = 0;
  std::uint64_t seed = 0;             ///< of this peer's nonces; no two peers' are the same
  std::uint64_t secret = 0;           ///< see SessionConfig
  Vec2 start;                         ///< m, where its avatar is first
  std::optional<Endpoint> contact{};  ///< of anybody in the crowd; absent: it is the crowd's first peer
  std::function<void(Region, const sync::FoldState&, std::uint64_t hash)> on_confirmed{};
};

struct CrowdStats {
  std::uint64_t handovers = 0;  ///< its avatar has gone home in another region
  std::uint64_t entered = 0;    ///< regions come into, founded ones included
  std::uint64_t founded = 0;
  std::uint64_t failed = 0;      ///< attempts to come in
  std::uint64_t merged = 0;      ///< times that it has taken over the world of another side
  std::uint64_t late = 0;        ///< ticks with the avatar a metre inside a region that it is not in yet
  std::uint64_t node_ticks = 0;  ///< steps of all its regions
  std::uint64_t datagrams = 0;
  std::uint64_t wire_bytes = 0;  ///< IP and UDP headers included
};

/// A whole peer of a crowd but for its clock, socket and input: a Participant in every region that it is in, and the
/// Finder that tells it who is there. Pure, as Participant is.
class CrowdPeer {
 public:
  explicit CrowdPeer(const CrowdConfig& config);

  /// As in Replica, in a region where it plays.
  void push(Region r, EntityId body, Vec2 velocity);
  void receive(const Endpoint& from, std::span<const std::byte> datagram, Micros local);
  /// As in Participant.
  void unreachable(const Endpoint& at, Micros local);
  /// Everything that is due. `target`: where the avatar is driven in a tick, m.
  void turn(const std::function<Vec2(Tick)>& target, Micros local);
  /// When to take a turn next.
  Micros next_due() const;
  /// As in Participant.
  std::span<const node::Parcel> take_outgoing();
  /// What people should know, and of which region; empty afterwards.
  std::vector<std::pair<Region, node::SessionEvent>> take_events();
  /// Says goodbye everywhere, and no more than that from now on.
  void leave(Micros local);
  /// After leaving: it may end.
  bool gone() const { return leaving_ && places_.empty(); }

  /// Plays: is at home somewhere.
  bool playing() const { return home_.has_value() && places_.contains(*home_); }
  Region home() const { return *home_; }
  /// Local time of its next tick; only while it plays.
  Micros next_step() const { return places_.at(*home_).peer->next_step(); }
  Tick now() const { return places_.at(*home_).peer->replica().now(); }
  const BodyState& avatar() const { return avatar_; }
  /// The regions where it is a member and stays, with their participants.
  std::vector<Post> posts() const;
  const CrowdStats& stats() const { return stats_; }
  const Handover& handover() const { return handover_; }
  const Finder& finder() const { return finder_; }
  std::uint64_t updates() const;

 private:
  struct Place {
    std::unique_ptr<node::Participant> peer;
    std::optional<Endpoint> by{};  ///< whom it has asked to be let in; absent: it has founded the region
    Tick said = -1;        ///< its last word on whether it is going is of this tick or an earlier one; -1: not said yet
    int incarnation = -1;  ///< of the participant, when it was looked at last
  };
  void note_life(Place& place);
  void say_goodbye(Micros local);
  void find(Micros local);
  void enter(Region r, const std::optional<Endpoint>& member, Micros local);
  Standing standing(bool with_fellows, Micros local) const;
  void tick(Vec2 target, Micros local);
  void lead(Region r, Place& place, const BodyState& before, Vec2 target, Micros local);
  bool drives(const Place& place) const;
  void steer(Micros local);
  void go_home();
  void reconsider(Micros local);
  static void say_whether_going(Place& place, bool go);
  static bool may_leave(const Place& place);
  void end_places(Micros local);
  void adapt_thresholds();
  void retire(Place& place);

  CrowdConfig config_;
  std::map<Region, Place> places_;
  std::map<Region, Micros> retry_;  ///< not to be asked for before
  std::vector<Region> wanted_;
  std::optional<Region> home_;
  BodyState avatar_;
  Handover handover_;
  Finder finder_;
  CrowdStats stats_;
  node::Outbox outgoing_;
  std::uint64_t past_updates_ = 0;  ///< of regions it has left
  std::uint64_t attempts_ = 0;
  std::vector<std::pair<Region, node::SessionEvent>> events_;
  Micros knocked_ = 0;
  bool leaving_ = false;
};

/// How many times the usual threshold an avatar's may be in a region where it is a guest, by its distance from the
/// nearest avatar at home there or body that moves: once within 4 m, once more for every 2 m beyond, 8 times at most.
float coarseness_of(const Plane& plane, Region r, const node::Replica& n);

}  // namespace padr::crowd
