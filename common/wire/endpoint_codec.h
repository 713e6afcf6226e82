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

/// Into a message that has an address and a port.
template <typename Message>
void put_endpoint(const Endpoint& e, Message& out) {
  out.set_address(address_bytes(e));
  out.set_port(e.port);
}

/// False unless it is a place that can be sent to.
template <typename Message>
bool take_endpoint(const Message& in, Endpoint& out) {
  const std::string& address = in.address();
  const bool keyed = address.size() == out.address.size() + out.key.size();
  if ((!keyed && address.size() != out.address.size()) || in.port() > 0xFFFF) return false;
  std::copy_n(address.begin(), out.address.size(), out.address.begin());
  if (keyed) {
    std::copy(address.end() - static_cast<std::ptrdiff_t>(out.key.size()), address.end(), out.key.begin());
    if (!out.has_key()) return false;
  }
  out.port = static_cast<std::uint16_t>(in.port());
  return out.is_set();
}

}  // namespace padr::wire
