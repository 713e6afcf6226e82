#include "common/capture/udp_datagram.h"

#include <algorithm>

#include "common/capture/link_layer.h"

namespace padr::capture {
namespace {

constexpr std::uint32_t kUdp = 17;
constexpr std::size_t kUdpHeader = 8;
constexpr std::size_t kIpv6Header = 40;
constexpr std::size_t kLinkHeader = 14;  // Ethernet's; others that tell a protocol are longer

void take_ipv4(ByteView ip, std::size_t at, Endpoint& e) {
  e.address = {};
  e.address[10] = e.address[11] = 0xFF;
  for (std::size_t i = 0; i < 4; ++i) e.address[12 + i] = static_cast<std::uint8_t>(u8(ip, at + i));
}

void take_ipv6(ByteView ip, std::size_t at, Endpoint& e) {
  for (std::size_t i = 0; i < 16; ++i) e.address[i] = static_cast<std::uint8_t>(u8(ip, at + i));
}

/// `rest`: from the UDP header on, link padding taken off; `cut`: the capture has less than was sent.
Content take_udp(ByteView rest, bool cut, UdpDatagram& out) {
  if (rest.size() < kUdpHeader) return cut ? Content::kCutUdp : Content::kMalformed;
  out.from.port = static_cast<std::uint16_t>(be16(rest, 0));
  out.to.port = static_cast<std::uint16_t>(be16(rest, 2));
  const std::size_t length = be16(rest, 4);
  if (length < kUdpHeader || (!cut && length > rest.size())) return Content::kMalformed;
  out.payload_bytes = length - kUdpHeader;
  out.payload = rest.subspan(kUdpHeader, std::min(length, rest.size()) - kUdpHeader);
  return length > rest.size() ? Content::kCutUdp : Content::kUdp;
}

/// `cut`: the frame is.
Content take_v4(ByteView ip, bool cut, UdpDatagram& out) {
  if (ip.size() < 20) return cut ? Content::kCutHeaders : Content::kMalformed;
  const std::size_t header = (u8(ip, 0) & 15U) * 4;
  const std::size_t total = be16(ip, 2);
  if (header < 20 || total < header) return Content::kMalformed;
  if ((be16(ip, 6) & 0x3FFFU) != 0) return Content::kFragment;
  if (u8(ip, 9) != kUdp) return Content::kOther;
  take_ipv4(ip, 12, out.from);
  take_ipv4(ip, 16, out.to);
  out.wire_bytes = total;
  if (ip.size() < header) return Content::kCutUdp;
  return take_udp(ip.subspan(header, std::min(total, ip.size()) - header), ip.size() < total, out);
}

/// Bytes of an extension header that is to be stepped over; 0 if it is none, or one that ends the walk.
std::size_t extension(std::uint32_t kind, ByteView rest) {
  switch (kind) {
    case 0:    // hop by hop
    case 43:   // routing
    case 60:   // destination
    case 135:  // mobility
      return (u8(rest, 1) + 1) * 8;
    case 51:  // authentication
      return (u8(rest, 1) + 2) * 4;
    case 44:  // fragment, if it is the only one
      return 8;
    default:
      return 0;
  }
}

Content take_v6(ByteView ip, bool frame_cut, UdpDatagram& out) {
  if (ip.size() < kIpv6Header) return frame_cut ? Content::kCutHeaders : Content::kMalformed;
  const std::size_t total = kIpv6Header + be16(ip, 4);
  const bool cut = ip.size() < total;
  ByteView rest = ip.subspan(kIpv6Header, std::min(total, ip.size()) - kIpv6Header);
  std::uint32_t kind = u8(ip, 6);
  while (kind != kUdp) {
    if (rest.size() < 8)
      return cut || kind == 59 ? Content::kOther : rest.empty() ? Content::kOther : Content::kMalformed;
    if (kind == 44 && (be16(rest, 2) & 0xFFF9U) != 0) return Content::kFragment;
    const std::size_t length = extension(kind, rest);
    if (length == 0) return Content::kOther;
    if (length > rest.size()) return cut ? Content::kOther : Content::kMalformed;
    kind = u8(rest, 0);
    rest = rest.subspan(length);
  }
  take_ipv6(ip, 8, out.from);
  take_ipv6(ip, 24, out.to);
  out.wire_bytes = total;
  return take_udp(rest, cut, out);
}

}  // namespace

Content udp_of(const Frame& frame, UdpDatagram& out) {
  out = {};
  const auto ip = ip_of(frame.link_type, frame.bytes);
  if (!ip) return Content::kUnknownLink;
  const bool cut = frame.bytes.size() < frame.original;
  if (ip->empty()) return cut && frame.bytes.size() < kLinkHeader ? Content::kCutHeaders : Content::kOther;
  const std::uint32_t version = u8(*ip, 0) >> 4U;
  if (version == 4) return take_v4(*ip, cut, out);
  if (version == 6) return take_v6(*ip, cut, out);
  return Content::kOther;
}

}  // namespace padr::capture
