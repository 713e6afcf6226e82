#include "common/wire/handshake.h"

#include <algorithm>

namespace padr::wire {
namespace {

constexpr unsigned kKind = 3;
constexpr std::size_t kKeyAt = 4;
constexpr std::size_t kNumberAt = kKeyAt + sizeof(PublicKey);
constexpr std::size_t kCookieAt = kNumberAt + 8;
constexpr std::size_t kTagAt = kCookieAt + sizeof(Tag);
constexpr std::size_t kIdAt = kCookieAt;
constexpr std::size_t kGenerationAt = kIdAt + 4;
constexpr std::size_t kHasAt = kGenerationAt + 4;
static_assert(kHasAt + 8 == kTagAt);
static_assert(kTagAt + sizeof(Tag) == kHandshakeBytes);

enum class Type : std::uint8_t { kHello = 1, kCookie = 2, kIntroduction = 3, kAcceptance = 4, kRekey = 5 };

template <typename Number>
void put(std::span<std::byte> to, Number v) {
  for (std::size_t i = 0; i < sizeof v; ++i) to[i] = static_cast<std::byte>(v >> (8 * i));
}

template <typename Number>
Number get(std::span<const std::byte> from) {
  Number v = 0;
  for (std::size_t i = 0; i < sizeof v; ++i) v |= std::to_integer<Number>(from[i]) << (8 * i);
  return v;
}

/// All but the tag.
Bytes body(Type type, const PublicKey& key, std::uint64_t number, const Tag& cookie) {
  Bytes out(kHandshakeBytes);
  out[0] = kDatagramMagic[0];
  out[1] = kDatagramMagic[1];
  out[2] = static_cast<std::byte>(kProtocolVersion << 4U | kKind);
  out[3] = static_cast<std::byte>(type);
  std::copy_n(std::as_bytes(std::span(key)).begin(), key.size(), out.begin() + kKeyAt);
  put(std::span(out).subspan(kNumberAt), number);
  std::copy(cookie.begin(), cookie.end(), out.begin() + kCookieAt);
  return out;
}

Bytes with_tag(Bytes out, const Tag& tag) {
  std::copy(tag.begin(), tag.end(), out.begin() + kTagAt);
  return out;
}

Bytes keyed(Bytes out, const Key& key) {
  const Tag tag = tag_of(key, std::span(out).first(kTagAt));
  return with_tag(std::move(out), tag);
}

Bytes proven(Bytes out, const Key& key, std::uint64_t number) {
  const Tag tag = encrypt(key, number, std::span(out).first(kTagAt), {});
  return with_tag(std::move(out), tag);
}

Tag tag_in(std::span<const std::byte> d, std::size_t at) {
  Tag tag{};
  std::copy_n(d.begin() + static_cast<std::ptrdiff_t>(at), tag.size(), tag.begin());
  return tag;
}

}  // namespace

Key handshake_key(const Key& session) {
  return derive_key(session, "padr handshake");
}

Bytes encode_handshake(const Hello& h, const Key& handshake_key) {
  return keyed(body(Type::kHello, h.key, h.nonce, {}), handshake_key);
}

Bytes encode_handshake(const Cookie& c, const Key& handshake_key) {
  return keyed(body(Type::kCookie, c.key, c.nonce, c.cookie), handshake_key);
}

Bytes encode_handshake(const Introduction& i, const Key& pair) {
  return proven(body(Type::kIntroduction, i.key, i.number, i.cookie), pair, i.number);
}

Bytes encode_handshake(const Acceptance& a, const Key& pair) {
  return proven(body(Type::kAcceptance, a.key, a.number, {}), pair, a.number);
}

Bytes encode_handshake(const Rekey& r, const Key& pair) {
  Tag rest{};
  const std::span<std::byte> room(rest);
  put(room, r.id);
  put(room.subspan(kGenerationAt - kCookieAt), r.generation);
  put(room.subspan(kHasAt - kCookieAt), r.has);
  return proven(body(Type::kRekey, r.exchange, r.number, rest), pair, r.number);
}

std::uint64_t beginning_of(const PublicKey& key) {
  return get<std::uint64_t>(std::as_bytes(std::span(key)));
}

bool is_handshake(std::span<const std::byte> d) {
  return d.size() == kHandshakeBytes && d[0] == kDatagramMagic[0] && d[1] == kDatagramMagic[1] &&
         std::to_integer<unsigned>(d[2]) == (kProtocolVersion << 4U | kKind) && std::to_integer<unsigned>(d[3]) >= 1 &&
         std::to_integer<unsigned>(d[3]) <= static_cast<unsigned>(Type::kRekey);
}

std::optional<Handshake> decode_handshake(std::span<const std::byte> d, const Key& handshake_key) {
  if (!is_handshake(d)) return std::nullopt;
  PublicKey key{};
  std::transform(d.begin() + kKeyAt, d.begin() + kNumberAt, key.begin(),
                 [](std::byte b) { return std::to_integer<std::uint8_t>(b); });
  const auto number = get<std::uint64_t>(d.subspan(kNumberAt));
  const Tag cookie = tag_in(d, kCookieAt);
  const auto type = static_cast<Type>(d[3]);
  if (type == Type::kIntroduction) return Introduction{key, number, cookie};
  if (type == Type::kAcceptance) return Acceptance{key, number};
  if (type == Type::kRekey)
    return Rekey{key, number, get<std::uint32_t>(d.subspan(kIdAt)), get<std::uint32_t>(d.subspan(kGenerationAt)),
                 get<std::uint64_t>(d.subspan(kHasAt))};
  if (!same(tag_in(d, kTagAt), tag_of(handshake_key, d.first(kTagAt)))) return std::nullopt;
  if (type == Type::kHello) return Hello{key, number};
  return Cookie{key, number, cookie};
}

bool proves(std::span<const std::byte> d, const Key& pair, std::uint64_t number) {
  return decrypt(pair, number, d.first(kTagAt), {}, tag_in(d, kTagAt));
}

}  // namespace padr::wire
