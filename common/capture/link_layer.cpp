#include "common/capture/link_layer.h"

#include "common/capture/frame.h"

namespace padr::capture {
namespace {

constexpr std::uint32_t kTypeIpv4 = 0x0800;
constexpr std::uint32_t kTypeIpv6 = 0x86DD;

bool is_vlan(std::uint32_t type) {
  return type == 0x8100 || type == 0x88A8 || type == 0x9100;
}

/// What follows a protocol type that stands before `rest`, behind any number of VLAN tags.
ByteView behind(std::uint32_t type, ByteView rest) {
  while (is_vlan(type)) {
    if (rest.size() < 4) return {};
    type = be16(rest, 2);
    rest = rest.subspan(4);
  }
  return type == kTypeIpv4 || type == kTypeIpv6 ? rest : ByteView{};
}

ByteView typed(ByteView frame, std::size_t type_at, std::size_t header) {
  if (frame.size() < header) return {};
  return behind(be16(frame, type_at), frame.subspan(header));
}

/// Loopback headers tell an address family: 2 is IPv4 everywhere, IPv6 has a number by system (BSDs, macOS, Linux).
ByteView loopback(std::uint32_t family, ByteView frame) {
  const bool known = family == 2 || family == 10 || family == 24 || family == 28 || family == 30;
  return known ? frame.subspan(4) : ByteView{};
}

}  // namespace

std::optional<ByteView> ip_of(std::uint32_t link_type, ByteView frame) {
  switch (link_type) {
    case kLinkEthernet:
      return typed(frame, 12, 14);
    case kLinkCooked:
      return typed(frame, 14, 16);
    case kLinkCooked2:
      return typed(frame, 0, 20);
    case kLinkNull: {
      if (frame.size() < 4) return ByteView{};
      // In the byte order of the machine that captured, which need not be that of the file.
      const std::uint32_t family = le32(frame, 0) < 0x10000 ? le32(frame, 0) : be32(frame, 0);
      return loopback(family, frame);
    }
    case kLinkLoop:
      return frame.size() < 4 ? ByteView{} : loopback(be32(frame, 0), frame);
    case kLinkRaw:
    case 12:  // DLT_RAW of most systems, and of OpenBSD: some programs write these numbers into files
    case 14:
    case kLinkIpv4:
    case kLinkIpv6:
      return frame;
    default:
      return std::nullopt;
  }
}

}  // namespace padr::capture
