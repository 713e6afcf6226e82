#include "common/wire/sealed.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace padr::wire {
namespace {

constexpr unsigned kModeShift = 2;
constexpr unsigned kKindMask = 3;

void put32(std::span<std::byte> to, std::uint32_t v) {
  for (unsigned i = 0; i < 4; ++i) to[i] = static_cast<std::byte>(v >> (8 * i));
}

std::uint32_t get32(std::span<const std::byte> from) {
  std::uint32_t v = 0;
  for (unsigned i = 0; i < 4; ++i) v |= std::to_integer<std::uint32_t>(from[i]) << (8 * i);
  return v;
}

Header header_of(std::span<const std::byte> head) {
  Header h;
  h.kind = static_cast<Kind>(std::to_integer<unsigned>(head[2]) & kKindMask);
  h.sender = std::to_integer<PeerId>(head[3]);
  h.session = static_cast<std::uint16_t>(std::to_integer<unsigned>(head[4]) | std::to_integer<unsigned>(head[5]) << 8U);
  return h;
}

/// The unsealed datagram with this header and payload.
void unsealed(std::span<const std::byte> head, std::span<const std::byte> payload, Bytes& out) {
  seal(header_of(head), payload, out);
}

}  // namespace

std::uint32_t short_id(const PublicKey& key) {
  return get32(std::as_bytes(std::span(key)));
}

std::optional<SealedHeader> read_sealed(std::span<const std::byte> d) {
  if (d.size() < kSealedHeaderBytes + kSealedTagBytes || d.size() > kMaxCarried) return std::nullopt;
  if (d[0] != kDatagramMagic[0] || d[1] != kDatagramMagic[1]) return std::nullopt;
  const auto third = std::to_integer<unsigned>(d[2]);
  const unsigned mode = third >> kModeShift & 3U;
  const auto kind = static_cast<Kind>(third & kKindMask);
  if (third >> 4U != kProtocolVersion || (mode != 1 && mode != 2)) return std::nullopt;
  if (kind != Kind::kCarried && d.size() > kMaxSealed) return std::nullopt;
  return SealedHeader{kind, static_cast<SealMode>(mode), get32(d.subspan(kHeaderBytes)),
                      get32(d.subspan(kHeaderBytes + 4))};
}

Bytes seal_with(const Key& key, SealMode mode, std::uint32_t id, std::uint64_t number,
                std::span<const std::byte> plain) {
  Bytes out;
  seal_with(key, mode, id, number, plain, out);
  return out;
}

void seal_with(const Key& key, SealMode mode, std::uint32_t id, std::uint64_t number, std::span<const std::byte> plain,
               Bytes& out) {
  assert(mode != SealMode::kNone && plain.size() >= kHeaderBytes + kTagBytes);
  assert(plain.size() + kSealGrowth <= kMaxCarried);
  const auto payload = plain.subspan(kHeaderBytes, plain.size() - kHeaderBytes - kTagBytes);
  out.resize(plain.size() + kSealGrowth);
  const std::span<std::byte> all(out);
  std::copy_n(plain.begin(), kHeaderBytes, out.begin());
  out[2] |= static_cast<std::byte>(static_cast<unsigned>(mode) << kModeShift);
  put32(all.subspan(kHeaderBytes), id);
  put32(all.subspan(kHeaderBytes + 4), static_cast<std::uint32_t>(number));
  std::copy(payload.begin(), payload.end(), out.begin() + kSealedHeaderBytes);
  const std::size_t open = kSealedHeaderBytes + (mode == SealMode::kAuth ? payload.size() : 0);
  const std::size_t end = kSealedHeaderBytes + payload.size();
  const Tag tag = encrypt(key, number, all.first(open), all.subspan(open, end - open));
  std::copy(tag.begin(), tag.end(), out.begin() + static_cast<std::ptrdiff_t>(end));
}

std::optional<Bytes> unseal_with(const Key& key, std::uint64_t number, std::span<const std::byte> sealed) {
  Bytes out;
  if (!unseal_with(key, number, sealed, out)) return std::nullopt;
  return out;
}

bool unseal_with(const Key& key, std::uint64_t number, std::span<const std::byte> sealed, Bytes& out) {
  const auto h = read_sealed(sealed);
  if (!h) return false;
  const std::size_t end = sealed.size() - kSealedTagBytes;
  const std::size_t open = h->mode == SealMode::kAuth ? end : kSealedHeaderBytes;
  Tag tag{};
  std::copy(sealed.begin() + static_cast<std::ptrdiff_t>(end), sealed.end(), tag.begin());
  std::array<std::byte, kMaxCarriedPayload> room{};
  const std::span<std::byte> text = std::span(room).first(end - open);
  std::copy(sealed.begin() + static_cast<std::ptrdiff_t>(open), sealed.begin() + static_cast<std::ptrdiff_t>(end),
            text.begin());
  if (!decrypt(key, number, sealed.first(open), text, tag)) return false;
  unsealed(sealed, h->mode == SealMode::kEncrypt ? text : sealed.subspan(kSealedHeaderBytes, end - kSealedHeaderBytes),
           out);
  return true;
}

std::optional<Bytes> unseal_unchecked(std::span<const std::byte> sealed) {
  const auto h = read_sealed(sealed);
  if (!h || h->mode != SealMode::kAuth) return std::nullopt;
  Bytes out;
  unsealed(sealed, sealed.subspan(kSealedHeaderBytes, sealed.size() - kSealedHeaderBytes - kSealedTagBytes), out);
  return out;
}

void encode_carried(const Carried& carried, Bytes& out) {
  assert(carried.sealed.size() >= kHeaderBytes + kTagBytes && carried.sealed.size() <= kMaxSealed);
  std::array<std::byte, kMaxCarriedPayload> room{};
  put32(room, carried.to);
  std::copy(carried.sealed.begin(), carried.sealed.end(), room.begin() + kCarriedHeaderBytes);
  Header header = header_of(carried.sealed);
  header.kind = Kind::kCarried;
  seal(header, std::span(room).first(kCarriedHeaderBytes + carried.sealed.size()), out);
}

std::optional<Carried> decode_carried(std::span<const std::byte> plain) {
  constexpr std::size_t kAround = kHeaderBytes + kTagBytes;
  if (plain.size() < kAround + kCarriedHeaderBytes + kAround || plain.size() > kAround + kMaxCarriedPayload)
    return std::nullopt;
  const auto payload = plain.subspan(kHeaderBytes, plain.size() - kAround);
  return Carried{get32(payload), payload.subspan(kCarriedHeaderBytes)};
}

}  // namespace padr::wire
