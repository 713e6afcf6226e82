#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "common/model/endpoint.h"

namespace padr::wire {

/// The address, and after it the key of whoever is there, if that is known.
inline std::string address_bytes(const Endpoint& e) {
  std::string bytes(e.address.begin(), e.address.end());
  if (e.has_key()) bytes.append(e.key.begin(), e.key.end());
  return bytes;
}

/// False unless it is a place that can be sent to.
inline bool take_endpoint(const std::string& address, std::uint32_t port, Endpoint& out) {
  const bool keyed = address.size() == out.address.size() + out.key.size();
  if ((!keyed && address.size() != out.address.size()) || port > 0xFFFF) return false;
  std::copy_n(address.begin(), out.address.size(), out.address.begin());
  if (keyed) {
    std::copy(address.end() - static_cast<std::ptrdiff_t>(out.key.size()), address.end(), out.key.begin());
    if (!out.has_key()) return false;
  }
  out.port = static_cast<std::uint16_t>(port);
  return out.is_set();
}

}  // namespace padr::wire
