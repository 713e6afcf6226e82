#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/link/link_seed.h"
#include "common/link/shim.h"

namespace padr::link {

/// The impaired links between peers 0 .. n-1 on virtual time, one for each ordered pair.
class LinkMesh {
 public:
  LinkMesh(std::size_t peers, const NetemSpec& spec, std::uint64_t netem_seed) : peers_(peers) {
    for (PeerId from = 0; from < peers; ++from)
      for (PeerId to = 0; to < peers; ++to)
        links_.push_back(std::make_unique<Shim>(spec, link_seed(netem_seed, from, to)));
  }

  void send(PeerId from, PeerId to, Micros now, std::span<const std::byte> datagram) {
    links_[index(from, to)]->accept(now, datagram);
  }
  /// Calls take(to, datagram) for each that has arrived by now: by sender, then receiver, then time.
  template <typename Take>
  void deliver(Micros now, const Take& take) {
    for (PeerId from = 0; from < peers_; ++from)
      for (PeerId to = 0; to < peers_; ++to)
        while (const auto datagram = links_[index(from, to)]->release(now)) take(to, *datagram);
  }
  const Shim& link(PeerId from, PeerId to) const { return *links_[index(from, to)]; }

 private:
  std::size_t index(PeerId from, PeerId to) const { return from * peers_ + to; }

  std::size_t peers_;
  std::vector<std::unique_ptr<Shim>> links_;
};

}  // namespace padr::link
