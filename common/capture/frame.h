#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace padr::capture {

/// Which way a packet went, seen from the machine that captured it.
enum class Direction : std::uint8_t { kUnknown, kInbound, kOutbound };

/// Link types that are understood: numbers of the registry at tcpdump.org/linktypes.html.
inline constexpr std::uint32_t kLinkNull = 0;       ///< BSD loopback, family in the capturing machine's byte order
inline constexpr std::uint32_t kLinkEthernet = 1;   ///< with or without VLAN tags
inline constexpr std::uint32_t kLinkRaw = 101;      ///< an IP packet
inline constexpr std::uint32_t kLinkLoop = 108;     ///< OpenBSD loopback, family in network byte order
inline constexpr std::uint32_t kLinkCooked = 113;   ///< Linux cooked, version 1
inline constexpr std::uint32_t kLinkIpv4 = 228;     ///< an IPv4 packet
inline constexpr std::uint32_t kLinkIpv6 = 229;     ///< an IPv6 packet
inline constexpr std::uint32_t kLinkCooked2 = 276;  ///< Linux cooked, version 2: what `tcpdump -i any` writes

/// One packet of a capture, as it is in the file.
struct Frame {
  std::uint64_t number = 0;     ///< 1, 2, ... in the file
  std::uint64_t offset = 0;     ///< bytes before its record or block
  std::int64_t time_ns = 0;     ///< since 1970, UTC, not negative; 0 if the capture does not say
  std::uint32_t interface = 0;  ///< counted from 0 through all sections of the file
  std::uint32_t link_type = 0;  ///< see above
  std::uint32_t original = 0;   ///< bytes of the packet on the wire; more than `bytes` has if it was cut (snaplen)
  Direction direction = Direction::kUnknown;
  std::span<const std::byte> bytes;  ///< until the next call of who gave it
};

}  // namespace padr::capture
