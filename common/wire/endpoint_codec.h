#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "common/model/endpoint.h"

namespace padr::wire {

inline std::string address_bytes(const Endpoint& e) {
  return {e.address.begin(), e.address.end()};
}

/// False unless it is a place that can be sent to.
inline bool take_endpoint(const std::string& address, std::uint32_t port, Endpoint& out) {
  if (address.size() != out.address.size() || port > 0xFFFF) return false;
  std::copy(address.begin(), address.end(), out.address.begin());
  out.port = static_cast<std::uint16_t>(port);
  return out.is_set();
}

}  // namespace padr::wire
