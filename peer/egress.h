#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/link/shim.h"
#include "common/model/endpoint.h"
#include "common/model/ids.h"

namespace padr::peer {

/// The impaired links out of this peer: every datagram goes through the shim of its link before the socket sees it.
///
/// Links between peers of a running session have the seeds that the lab gives them, and carry state datagrams only, so
/// that the same datagrams meet the same fate there. What is said before, when nobody has a number yet, goes through
/// links of its own, one an address.
class Egress {
 public:
  using Send = std::function<void(const Endpoint& to, std::span<const std::byte> datagram)>;
  struct Specs {
    link::NetemSpec all;
    std::map<PeerId, link::NetemSpec> by_peer;
    std::map<Endpoint, link::NetemSpec> by_address;
    std::uint64_t seed = 1;
  };

  Egress(Specs specs, Send send) : specs_(std::move(specs)), send_(std::move(send)) {}

  /// This peer's number, from now on; another than before in another incarnation.
  void sit(PeerId self);

  void session(const Endpoint& to, std::span<const std::byte> datagram, Micros now);
  /// To the peer of this number, at this address: a link with whoever sat there before, elsewhere, is given up, but for
  /// what is in it. Only after `sit`.
  void state(PeerId to, const Endpoint& at, std::span<const std::byte> datagram, Micros now);
  /// What the link to this peer, or all there are and will be, suffer from now on; what is in them keeps its time.
  void impair(std::optional<PeerId> peer, const link::NetemSpec& spec, Micros now);
  /// What the link of state datagrams to p, who is there, suffers.
  const link::NetemSpec& spec_of(PeerId p, const Endpoint& there) const { return spec_for(there.place(), p); }
  const link::NetemSpec& spec_of_all() const { return specs_.all; }

  /// Sends all that has left its link by `now`.
  void pump(Micros now);
  /// When to pump next; nothing if no datagram is held.
  std::optional<Micros> next_due() const;

  /// The link of state datagrams to p; null if none have been sent.
  const link::Shim* shim(PeerId p) const {
    const auto found = links_.find(p);
    return found == links_.end() ? nullptr : found->second.shim.get();
  }

 private:
  struct Link {
    Endpoint to;
    std::unique_ptr<link::Shim> shim;
  };
  const link::NetemSpec& spec_for(const Endpoint& to, std::optional<PeerId> peer) const;
  void enter(link::Shim& shim, const Endpoint& to, std::span<const std::byte> datagram, Micros now);
  void forget_idle();
  void retire(Link link);

  Specs specs_;
  Send send_;
  PeerId self_ = kNoPeer;
  std::map<PeerId, Link> links_;
  std::vector<Link> retired_;  ///< with what is still in them
  std::map<Endpoint, link::Shim> early_;
  bool holding_ = false;  ///< whether any link may hold anything
};

}  // namespace padr::peer
