#pragma once

#include "common/model/endpoint.h"

namespace padr {

/// Most addresses of its own that a peer tells others.
inline constexpr std::size_t kMostOwnAddresses = 4;

/// Global or private unicast, with a port: neither loopback, link-local, multicast nor broadcast, nor of no host.
inline bool is_of_one_host(const Endpoint& e) {
  if (!e.is_set() || e.is_loopback()) return false;
  if (e.is_v4()) {
    const auto a = e.address[12];
    return a != 0 && a != 127 && a < 224 && !(a == 169 && e.address[13] == 254);
  }
  const bool link_local = e.address[0] == 0xFE && (e.address[1] & 0xC0U) == 0x80;
  return e.address[0] != 0xFF && !link_local;
}

}  // namespace padr
