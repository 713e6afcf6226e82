#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "common/sync/bundle_pool.h"

namespace padr::sync {

/// What has been heard of every peer's updates: the bundles, and up to which tick they are known to be complete. What
/// is forgotten leaves its memory to what comes.
class UpdateLog {
 public:
  /// Nobody is there yet: all slots are closed at 0.
  explicit UpdateLog(int slots);

  /// Before anything else is filed of the slot: its updates below `first` are dealt with, and it is complete up to
  /// `complete`; the largest Tick: closed.
  void begin(PeerId peer, std::uint32_t first, Tick complete);

  /// Files a bundle; false if it was known already, is of a final tick or beyond its slot's end, or its peer has
  /// another of its tick.
  bool insert(const Bundle& bundle);
  /// Whether the same promise, that no bundle of a tick up to `tick` is numbered `count` or higher, is not true of what
  /// is here.
  bool contradicts(PeerId peer, Tick tick, std::uint32_t count) const;
  /// The peer says: all my bundles up to and including `tick` are numbered below `count`.
  void mark(PeerId peer, Tick tick, std::uint32_t count);
  /// Forgets what the peer has promised and not told: others may know better.
  void forget_promises(PeerId peer) { peers_[peer].waiting.clear(); }
  /// Who sat in the slot says no more, ever: it is complete for all time once its bundles below `count` are here. If it
  /// is already, those between its end and `count` never count: ticks after them may be confirmed.
  /// Forgets what is known beyond; the earliest tick of that, or the largest Tick.
  Tick close(PeerId peer, std::uint32_t count);
  /// Takes out what is known beyond the first hole, so that what fills the hole does not bring more with it.
  std::vector<Bundle> hold(PeerId peer);
  /// Another peer sits in a closed slot: its bundles are numbered from the old one's end on and of ticks after `since`.
  void open(PeerId peer, Tick since);
  /// Whether more has been promised than is here.
  bool waits(PeerId peer) const { return !peers_[peer].waiting.empty(); }
  bool closed(PeerId peer) const { return peers_[peer].end != kOpen; }

  /// The peer's bundle of that number, or of that tick; null if it is not kept.
  const Bundle* find(PeerId peer, std::uint32_t index) const;
  const Bundle* find_at(PeerId peer, Tick tick) const;
  /// A kept bundle of the peer with a higher number that is of no later tick, or with a lower one of no earlier tick;
  /// null if there is none.
  const Bundle* find_out_of_order(PeerId peer, std::uint32_t index, Tick tick) const;
  /// Known bundles of a tick, by ascending peer; empty if none.
  const std::vector<Bundle>& at(Tick tick) const;
  /// The last tick for which all of the peer's bundles are here; -1 if none; the largest Tick when closed.
  Tick complete(PeerId peer) const;
  /// The bundle has come, whether it is still kept or not.
  bool knows(PeerId peer, std::uint32_t index) const {
    return index < peers_[peer].have || peers_[peer].is_beyond(index);
  }
  /// The peer's bundles 0 .. have-1 are here.
  std::uint32_t have(PeerId peer) const { return peers_[peer].have; }
  /// Bit i: bundle have+1+i is here too (have itself is not).
  std::uint32_t have_beyond(PeerId peer) const;
  /// The known bundles of a slot numbered `from` and up, by tick. An honest peer's numbers rise with its ticks.
  std::vector<Bundle> of(PeerId peer, std::uint32_t from) const;
  /// All known bundles of ticks from `tick` on, by tick and peer.
  std::vector<Bundle> since(Tick tick) const;
  /// Ticks below `final` take no bundles any more; those below `keep`, too, are forgotten.
  void prune(Tick final, Tick keep);
  std::size_t size() const { return by_tick_.size(); }
  /// Numbers of a peer's bundles that are remembered beyond the first hole; kMostBeyond at most.
  std::size_t beyond(PeerId peer) const { return peers_[peer].beyond.size(); }

  /// So far beyond the first that is missing a bundle's number may be. Whoever is as far behind with telling what is
  /// missing is declared gone before.
  static constexpr std::uint32_t kMostBeyond = 2048;

 private:
  static constexpr std::uint32_t kOpen = 0xFFFFFFFFU;
  struct Mark {
    Tick tick = -1;
    std::uint32_t count = 0;
  };
  struct Peer {
    std::uint32_t have = 0;
    std::vector<std::uint32_t> beyond;  // indices above `have` that are here, ascending
    Tick complete = -1;
    std::vector<Mark> waiting;  // marks that promise more than is here
    std::uint32_t end = 0;      // closed: no bundle is numbered this or higher

    bool is_beyond(std::uint32_t index) const { return std::binary_search(beyond.begin(), beyond.end(), index); }
    /// Of an index that is not here yet.
    void arrives(std::uint32_t index);
  };
  using ByTick = std::map<Tick, std::vector<Bundle>>;
  void settle(Peer& p);
  std::vector<Bundle>& list_of(Tick tick);
  void make_ticks();
  /// Bundles numbered `from` and up, by tick.
  std::vector<Bundle> take_out(PeerId peer, std::uint32_t from);

  ByTick by_tick_;
  BundlePool pool_;
  std::vector<ByTick::node_type> spare_ticks_;  ///< with empty lists
  std::size_t ticks_made_ = 0;
  std::vector<Peer> peers_;
  Tick final_ = 0;
};

}  // namespace padr::sync
