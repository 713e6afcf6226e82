#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "common/link/link_seed.h"
#include "common/link/shim.h"

namespace padr::link {

/// The impaired links between parties 0, 1, 2, ... on virtual time: one for each ordered pair, from its first datagram
/// on.
class LinkMesh {
 public:
  using Seed = std::function<std::uint64_t(std::size_t from, std::size_t to)>;

  LinkMesh(const NetemSpec& spec, Seed seed) : spec_(spec), seed_(std::move(seed)) {}
  /// Between the peers of a session, as real peers' links.
  LinkMesh(const NetemSpec& spec, std::uint64_t netem_seed)
      : LinkMesh(spec, [netem_seed](std::size_t from, std::size_t to) {
          return link_seed(netem_seed, static_cast<PeerId>(from), static_cast<PeerId>(to));
        }) {}

  /// Between the parties of a testbed or a crowd, of whom there may be more than a session has slots.
  static LinkMesh between_parties(const NetemSpec& spec, std::uint64_t seed) {
    return {spec, [seed](std::size_t from, std::size_t to) { return derive_seed(seed, 0x11A7, from << 32U | to); }};
  }

  /// From now on each of so many parties may send in a thread of its own.
  void reserve(std::size_t parties) { links_.resize(std::max(links_.size(), parties)); }
  void send(std::size_t from, std::size_t to, Micros now, std::span<const std::byte> datagram) {
    link(from, to).accept(now, datagram);
  }
  /// Calls take(from, to, when, datagram) for each that arrives by `until`: by sender, then receiver, then time.
  template <typename Take>
  void deliver(Micros until, const Take& take) {
    for (std::size_t from = 0; from < links_.size(); ++from)
      for (auto& [to, link] : links_[from])
        for (auto due = link->next_due(); due && *due <= until; due = link->next_due())
          if (auto datagram = link->release(*due)) take(from, to, *due, std::move(*datagram));
  }
  /// New rules for all links from `now` on, those that are still to come included.
  void set_spec(Micros now, const NetemSpec& spec) {
    spec_ = spec;
    for (auto& receivers : links_)
      for (auto& [to, link] : receivers) link->set_spec(now, spec);
  }
  Shim& link(std::size_t from, std::size_t to) {
    reserve(from + 1);
    auto& link = links_[from][to];
    if (!link) link = std::make_unique<Shim>(spec_, seed_(from, to));
    return *link;
  }

 private:
  NetemSpec spec_;
  Seed seed_;
  std::vector<std::map<std::size_t, std::unique_ptr<Shim>>> links_;  ///< by sender, then receiver
};

}  // namespace padr::link
