#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/model/endpoint.h"
#include "common/model/ids.h"
#include "common/monitor/orders.h"

namespace padr::peer {

/// Links that are cut for a while, in one direction or both: with one peer, or with everybody.
class LinkCuts {
 public:
  using Ways = monitor::Ways;
  /// `peer` absent: all. `places`: where that peer is, or may be. Until `until`, microseconds; whole again at once if
  /// that is past.
  void cut(std::optional<PeerId> peer, std::vector<Endpoint> places, Micros until, Ways ways = Ways::kBoth) {
    if (peer) {
      by_peer_[*peer] = {std::move(places), until, ways};
    } else {
      all_ = {std::move(places), until, ways};
    }
  }

  /// Nothing goes there.
  bool is_cut_out(const Endpoint& to) const { return is_cut(to, Ways::kIn); }
  /// Nothing that comes from there is heard.
  bool is_cut_in(const Endpoint& from) const { return is_cut(from, Ways::kOut); }
  bool any() const { return all_ || !by_peer_.empty(); }

  /// Takes out what is over by `now`; kNoPeer stands for all.
  std::vector<PeerId> take_over(Micros now) {
    std::vector<PeerId> over;
    if (all_ && now >= all_->until) {
      over.push_back(kNoPeer);
      all_.reset();
    }
    for (const auto& [peer, c] : by_peer_)
      if (now >= c.until) over.push_back(peer);
    std::erase_if(by_peer_, [now](const auto& c) { return now >= c.second.until; });
    return over;
  }
  std::optional<Micros> next_due() const {
    std::optional<Micros> due;
    if (all_) due = all_->until;
    for (const auto& [peer, c] : by_peer_)
      if (!due || c.until < *due) due = c.until;
    return due;
  }

 private:
  struct Cut {
    std::vector<Endpoint> places;
    Micros until = 0;
    Ways ways = Ways::kBoth;
  };
  bool is_cut(const Endpoint& with, Ways but_for) const {
    if (all_ && all_->ways != but_for) return true;
    const auto is_there = [&with](const Endpoint& place) { return same_place(place, with); };
    return std::any_of(by_peer_.begin(), by_peer_.end(), [&](const auto& c) {
      return c.second.ways != but_for && std::any_of(c.second.places.begin(), c.second.places.end(), is_there);
    });
  }

  std::optional<Cut> all_;
  std::map<PeerId, Cut> by_peer_;
};

}  // namespace padr::peer
