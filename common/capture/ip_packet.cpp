#include "common/capture/ip_packet.h"

#include <cassert>

#include "common/capture/byte_order.h"

namespace padr::capture {
namespace {

constexpr std::size_t kUdpHeader = 8;
constexpr std::size_t kMostPayload = 65507;
constexpr std::uint32_t kUdp = 17;
constexpr std::uint32_t kHops = 64;

void put8(std::vector<std::byte>& out, std::uint32_t v) {
  out.push_back(static_cast<std::byte>(v & 0xFFU));
}
void put16(std::vector<std::byte>& out, std::uint32_t v) {
  put8(out, v >> 8U);
  put8(out, v);
}
void put_address(std::vector<std::byte>& out, const Endpoint& e, std::size_t from) {
  for (std::size_t i = from; i < e.address.size(); ++i) put8(out, e.address[i]);
}

/// RFC 1071, not yet folded.
std::uint32_t sum_of(ByteView bytes) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) sum += be16(bytes, i);
  if (bytes.size() % 2 == 1) sum += u8(bytes, bytes.size() - 1) << 8U;
  return sum;
}

std::uint32_t folded(std::uint32_t sum) {
  while (sum >> 16U != 0) sum = (sum & 0xFFFFU) + (sum >> 16U);
  return ~sum & 0xFFFFU;
}

void set16(std::vector<std::byte>& out, std::size_t at, std::uint32_t v) {
  out[at] = static_cast<std::byte>(v >> 8U);
  out[at + 1] = static_cast<std::byte>(v & 0xFFU);
}

/// Returns where in `out` the addresses begin.
std::size_t put_ipv4(const Endpoint& from, const Endpoint& to, std::size_t length, std::uint16_t id,
                     std::vector<std::byte>& out) {
  put16(out, 0x4500);
  put16(out, static_cast<std::uint32_t>(20 + length));
  put16(out, id);
  put16(out, 0x4000);  // not to be fragmented
  put16(out, kHops << 8U | kUdp);
  put16(out, 0);
  put_address(out, from, 12);
  put_address(out, to, 12);
  set16(out, 10, folded(sum_of(out)));
  return 12;
}

std::size_t put_ipv6(const Endpoint& from, const Endpoint& to, std::size_t length, std::vector<std::byte>& out) {
  put16(out, 0x6000);
  put16(out, 0);
  put16(out, static_cast<std::uint32_t>(length));
  put16(out, kUdp << 8U | kHops);
  put_address(out, from, 0);
  put_address(out, to, 0);
  return 8;
}

}  // namespace

void make_udp_packet(const Endpoint& from, const Endpoint& to, std::span<const std::byte> payload, std::uint16_t id,
                     std::vector<std::byte>& out) {
  assert(payload.size() <= kMostPayload);
  out.clear();
  const std::size_t length = kUdpHeader + payload.size();
  const std::size_t addresses = to.is_v4() ? put_ipv4(from, to, length, id, out) : put_ipv6(from, to, length, out);
  const std::size_t udp = out.size();
  put16(out, from.port);
  put16(out, to.port);
  put16(out, static_cast<std::uint32_t>(length));
  put16(out, 0);
  out.insert(out.end(), payload.begin(), payload.end());
  // The pseudo header of RFC 768 and RFC 8200: addresses, protocol, length.
  const ByteView all(out);
  const std::uint32_t sum = sum_of(all.subspan(addresses, udp - addresses)) + kUdp +
                            static_cast<std::uint32_t>(length) + sum_of(all.subspan(udp));
  const std::uint32_t check = folded(sum);
  set16(out, udp + 6, check == 0 ? 0xFFFF : check);  // 0 says that there is none
}

}  // namespace padr::capture
