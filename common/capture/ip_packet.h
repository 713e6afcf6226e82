#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/model/endpoint.h"

namespace padr::capture {

/// The IP packet that carries a UDP datagram from here to there, checksums and all: IPv4 if `to` is one, else IPv6.
/// `id`: the packet's identification (IPv4). `out` is overwritten. The payload is at most 65,507 bytes.
void make_udp_packet(const Endpoint& from, const Endpoint& to, std::span<const std::byte> payload, std::uint16_t id,
                     std::vector<std::byte>& out);

}  // namespace padr::capture
