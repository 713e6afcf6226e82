#pragma once

#include <map>
#include <set>
#include <utility>
#include <vector>

#include "common/crowd/regions.h"
#include "common/participant/participant.h"

namespace padr::crowd {

/// One of a peer's regions, while it plays there.
struct Post {
  Region region;
  node::Participant* peer = nullptr;
};

/// A peer's part in handing bodies over from one region to another.
///
/// Nothing is remembered that matters: what is still to be done shows in the agreed worlds, so whoever is in both
/// regions can go on where another one has ended.
class Handover {
 public:
  explicit Handover(const Plane& plane) : plane_(plane) {}

  /// Publishes the entries and exits that fall to this peer. `posts`: all of its regions, at the same tick.
  void work(const std::vector<Post>& posts);
  /// Regions that this peer should be in, or stay in, for a body's sake, as of the last work.
  const std::set<Region>& errands() const { return errands_; }

  std::uint64_t entries() const { return entries_; }
  std::uint64_t exits() const { return exits_; }

  static constexpr Tick kNextInLine = kTicksPerSecond;  ///< until the next in line does what should have been done

 private:
  using Duty = std::pair<sync::BodyName, std::pair<sync::Passage::Kind, std::uint32_t>>;
  void consider_binding(const Post& from, EntityId b);
  void consider_entry(const Post& from, EntityId b, const std::vector<Post>& posts);
  void consider_exit(const Post& from, EntityId b, const std::vector<Post>& posts);
  bool falls_to_me(const Duty& duty, int place_in_line, Tick now);
  void declare(const Post& at, const sync::Passage& p);

  Plane plane_;
  std::set<Region> errands_;
  std::map<Duty, Tick> due_;  ///< since when it has been
  std::set<Duty> seen_;       ///< in this round
  std::map<Region, sync::Bundle> declared_;
  std::uint64_t entries_ = 0;
  std::uint64_t exits_ = 0;
};

}  // namespace padr::crowd
