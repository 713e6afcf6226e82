#include "peer/egress.h"

#include <algorithm>
#include <utility>

#include "common/link/link_seed.h"
#include "common/model/rng.h"

namespace padr::peer {
namespace {

/// A stranger can make the peer answer. Answers to more addresses than this at a time are not impaired.
constexpr std::size_t kMostEarlyLinks = 256;

/// A seed that depends on the address alone, in a stream that no pair of peers has.
std::uint64_t early_seed(std::uint64_t seed, const Endpoint& to) {
  constexpr std::uint64_t kEarly = 1000;
  std::uint64_t s = derive_seed(seed, kEarly, to.port);
  for (const std::uint8_t byte : to.address) s = derive_seed(s, byte);
  return s;
}

}  // namespace

const link::NetemSpec& Egress::spec_for(const Endpoint& to, std::optional<PeerId> peer) const {
  if (const auto own = specs_.by_address.find(to); own != specs_.by_address.end()) return own->second;
  if (peer)
    if (const auto own = specs_.by_peer.find(*peer); own != specs_.by_peer.end()) return own->second;
  return specs_.all;
}

void Egress::sit(PeerId self) {
  if (self == self_) return;
  self_ = self;
  for (auto& [peer, link] : links_) retire(std::move(link));
  links_.clear();
}

void Egress::retire(Link link) {
  if (link.shim->in_flight() > 0) retired_.push_back(std::move(link));
}

void Egress::session(const Endpoint& to, std::span<const std::byte> datagram, Micros now) {
  auto it = early_.find(to);
  if (it == early_.end()) {
    if (early_.size() >= kMostEarlyLinks) forget_idle();
    if (early_.size() >= kMostEarlyLinks) return send_(to, datagram);
    it = early_.try_emplace(to, spec_for(to, std::nullopt), early_seed(specs_.seed, to)).first;
  }
  enter(it->second, to, datagram, now);
}

void Egress::state(PeerId to, const Endpoint& at, std::span<const std::byte> datagram, Micros now) {
  Link& l = links_[to];
  if (l.shim && l.to != at) retire(std::exchange(l, {}));
  if (!l.shim) l = {at, std::make_unique<link::Shim>(spec_for(at, to), link::link_seed(specs_.seed, self_, to))};
  enter(*l.shim, at, datagram, now);
}

void Egress::enter(link::Shim& shim, const Endpoint& to, std::span<const std::byte> datagram, Micros now) {
  if (shim.pass(now, datagram)) return send_(to, datagram);
  shim.accept(now, datagram);
  holding_ = true;
}

void Egress::impair(std::optional<PeerId> peer, const link::NetemSpec& spec, Micros now) {
  if (!peer) {
    specs_.all = spec;
    specs_.by_peer.clear();
    specs_.by_address.clear();
    for (auto& [to, shim] : early_) shim.set_spec(now, spec);
    for (auto& [to, link] : links_) link.shim->set_spec(now, spec);
    return;
  }
  specs_.by_peer[*peer] = spec;
  const auto found = links_.find(*peer);
  if (found == links_.end()) return;
  specs_.by_address.erase(found->second.to);
  found->second.shim->set_spec(now, spec);
}

void Egress::pump(Micros now) {
  if (!holding_) return;
  holding_ = false;
  const auto empty = [&](link::Shim& shim, const Endpoint& to) {
    while (const auto datagram = shim.release(now)) send_(to, *datagram);
    holding_ = holding_ || shim.in_flight() > 0;
  };
  for (auto& [to, shim] : early_) empty(shim, to);
  for (auto& [peer, l] : links_) empty(*l.shim, l.to);
  for (Link& l : retired_) empty(*l.shim, l.to);
  std::erase_if(retired_, [](const Link& l) { return l.shim->in_flight() == 0; });
}

std::optional<Micros> Egress::next_due() const {
  std::optional<Micros> due;
  if (!holding_) return due;
  const auto take = [&due](const link::Shim& s) {
    const auto next = s.next_due();
    if (next && (!due || *next < *due)) due = next;
  };
  for (const auto& [to, shim] : early_) take(shim);
  for (const auto& [peer, l] : links_) take(*l.shim);
  for (const Link& l : retired_) take(*l.shim);
  return due;
}

void Egress::forget_idle() {
  std::erase_if(early_, [](const auto& link) { return link.second.in_flight() == 0; });
}

}  // namespace padr::peer
