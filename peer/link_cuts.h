#pragma once

#include <map>
#include <optional>
#include <vector>

#include "common/model/endpoint.h"
#include "common/model/ids.h"

namespace padr::peer {

/// Links that are cut for a while: with one peer, or with everybody.
class LinkCuts {
 public:
  /// `peer` absent: all. `at`: where that peer is. Until `until`, microseconds; whole again at once if that is past.
  void cut(std::optional<PeerId> peer, const Endpoint& at, Micros until) {
    if (peer) {
      by_peer_[*peer] = {at, until};
    } else {
      all_until_ = until;
    }
  }

  bool is_cut(const Endpoint& with) const {
    if (all_until_) return true;
    for (const auto& [peer, c] : by_peer_)
      if (same_place(c.at, with)) return true;
    return false;
  }
  bool any() const { return all_until_ || !by_peer_.empty(); }

  /// Takes out what is over by `now`; kNoPeer stands for all.
  std::vector<PeerId> take_over(Micros now) {
    std::vector<PeerId> over;
    if (all_until_ && now >= *all_until_) {
      over.push_back(kNoPeer);
      all_until_.reset();
    }
    for (const auto& [peer, c] : by_peer_)
      if (now >= c.until) over.push_back(peer);
    std::erase_if(by_peer_, [now](const auto& c) { return now >= c.second.until; });
    return over;
  }
  std::optional<Micros> next_due() const {
    std::optional<Micros> due = all_until_;
    for (const auto& [peer, c] : by_peer_)
      if (!due || c.until < *due) due = c.until;
    return due;
  }

 private:
  struct Cut {
    Endpoint at;
    Micros until = 0;
  };
  std::optional<Micros> all_until_;
  std::map<PeerId, Cut> by_peer_;
};

}  // namespace padr::peer
