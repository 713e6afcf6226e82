#include "common/wire/seal.h"

#include <boost/crc.hpp>
#include <cassert>

namespace padr::wire {
namespace {

std::uint32_t tag_of(std::span<const std::byte> bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

}  // namespace

Bytes seal(const Header& header, std::span<const std::byte> payload) {
  Bytes out;
  seal(header, payload, out);
  return out;
}

void seal(const Header& header, std::span<const std::byte> payload, Bytes& out) {
  assert(payload.size() <= kMaxPayload || header.kind == Kind::kCarried);
  out.clear();
  out.reserve(kHeaderBytes + payload.size() + kTagBytes);
  out.push_back(kDatagramMagic[0]);
  out.push_back(kDatagramMagic[1]);
  out.push_back(static_cast<std::byte>((kProtocolVersion << 4U) | static_cast<unsigned>(header.kind)));
  out.push_back(static_cast<std::byte>(header.sender));
  out.push_back(static_cast<std::byte>(header.session & 0xFFU));
  out.push_back(static_cast<std::byte>(header.session >> 8U));
  out.insert(out.end(), payload.begin(), payload.end());
  const std::uint32_t tag = tag_of(out);
  for (unsigned shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::byte>((tag >> shift) & 0xFFU));
}

std::optional<Opened> open(std::span<const std::byte> datagram, SealError& error, std::uint8_t* version) {
  const auto drop = [&error](SealError e) {
    error = e;
    return std::nullopt;
  };
  error = SealError::kNone;
  if (datagram.size() < kHeaderBytes + kTagBytes) return drop(SealError::kTooShort);
  if (datagram.size() > kMaxDatagram) return drop(SealError::kTooLong);
  if (datagram[0] != kDatagramMagic[0] || datagram[1] != kDatagramMagic[1]) return drop(SealError::kMagic);
  const std::span<const std::byte> covered = datagram.first(datagram.size() - kTagBytes);
  std::uint32_t tag = 0;
  for (std::size_t i = 0; i < kTagBytes; ++i)
    tag |= std::to_integer<std::uint32_t>(datagram[covered.size() + i]) << (8U * i);
  if (tag != tag_of(covered)) return drop(SealError::kTag);
  const auto kind_byte = std::to_integer<std::uint8_t>(datagram[2]);
  if (version != nullptr) *version = static_cast<std::uint8_t>(kind_byte >> 4U);
  if (kind_byte >> 4U != kProtocolVersion) return drop(SealError::kVersion);
  if ((kind_byte & 0x0FU) > static_cast<unsigned>(Kind::kMembership)) return drop(SealError::kKind);
  Opened o;
  o.header.kind = static_cast<Kind>(kind_byte & 0x0FU);
  o.header.sender = std::to_integer<PeerId>(datagram[3]);
  o.header.session =
      static_cast<std::uint16_t>(std::to_integer<unsigned>(datagram[4]) | std::to_integer<unsigned>(datagram[5]) << 8U);
  o.payload = covered.subspan(kHeaderBytes);
  o.datagram = datagram;
  return o;
}

}  // namespace padr::wire
