#include "common/wire/secret.h"

#include <sodium.h>

#include <algorithm>
#include <cassert>
#include <initializer_list>

namespace padr::wire {
namespace {

static_assert(crypto_scalarmult_BYTES == sizeof(Key) && crypto_scalarmult_SCALARBYTES == sizeof(Key));
static_assert(crypto_sign_SEEDBYTES == sizeof(Key) && crypto_sign_PUBLICKEYBYTES == sizeof(PublicKey));
static_assert(crypto_sign_SECRETKEYBYTES == sizeof(SigningKey) && crypto_sign_BYTES == sizeof(sync::Signature));
static_assert(crypto_stream_xchacha20_KEYBYTES == sizeof(Key));

constexpr std::size_t kNumberBytes = 8;
static_assert(crypto_stream_xchacha20_NONCEBYTES == sizeof(Tag) + kNumberBytes);

const unsigned char* raw(std::span<const std::byte> bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

unsigned char* into(std::span<std::byte> bytes) {
  return reinterpret_cast<unsigned char*>(bytes.data());
}

std::array<std::byte, kNumberBytes> little_endian(std::uint64_t number) {
  std::array<std::byte, kNumberBytes> bytes{};
  for (unsigned i = 0; i < kNumberBytes; ++i) bytes[i] = static_cast<std::byte>(number >> (8 * i));
  return bytes;
}

/// BLAKE2b-256, keyed with `key`, of `name`, a secret that two share, and the public keys of sender and receiver.
Key one_way(const Key& key, std::string_view name, const Key& shared, const PublicKey& from, const PublicKey& to) {
  crypto_generichash_state state;
  Key out{};
  crypto_generichash_init(&state, key.data(), key.size(), out.size());
  crypto_generichash_update(&state, reinterpret_cast<const unsigned char*>(name.data()), name.size());
  for (const PublicKey* part : std::initializer_list<const PublicKey*>{&shared, &from, &to})
    crypto_generichash_update(&state, part->data(), part->size());
  crypto_generichash_final(&state, out.data(), out.size());
  sodium_memzero(&state, sizeof state);
  return out;
}

/// What a datagram with this number has its tag over.
Tag tag_of(const Key& key, std::uint64_t number, std::span<const std::byte> open, std::span<const std::byte> text) {
  crypto_generichash_state state;
  Tag tag{};
  crypto_generichash_init(&state, key.data(), key.size(), tag.size());
  const auto digits = little_endian(number);
  for (const std::span<const std::byte> part : {open, text, std::span<const std::byte>(digits)})
    if (!part.empty()) crypto_generichash_update(&state, raw(part), part.size());
  crypto_generichash_final(&state, into(tag), tag.size());
  sodium_memzero(&state, sizeof state);
  return tag;
}

/// Hides `text`, or shows it again, in place.
void mix(const Key& key, const Tag& tag, std::uint64_t number, std::span<std::byte> text) {
  if (text.empty()) return;
  const Key cipher = derive_key(key, "padr cipher");
  std::array<std::byte, sizeof(Tag) + kNumberBytes> nonce{};
  const auto digits = little_endian(number);
  std::copy(digits.begin(), digits.end(), std::copy(tag.begin(), tag.end(), nonce.begin()));
  crypto_stream_xchacha20_xor(into(text), into(text), text.size(), into(nonce), cipher.data());
}

}  // namespace

void choose_fast_code() {
  const int result = sodium_init();
  assert(result >= 0);
  static_cast<void>(result);
}

void wipe(std::span<std::byte> bytes) {
  sodium_memzero(bytes.data(), bytes.size());
}

Key derive_key(const Key& secret, std::string_view name) {
  Key out{};
  crypto_generichash(out.data(), out.size(), reinterpret_cast<const unsigned char*>(name.data()), name.size(),
                     secret.data(), secret.size());
  return out;
}

Tag tag_of(const Key& key, std::span<const std::byte> bytes) {
  Tag tag{};
  crypto_generichash(into(tag), tag.size(), raw(bytes), bytes.size(), key.data(), key.size());
  return tag;
}

bool same(const Tag& a, const Tag& b) {
  return sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

SigningKey signing_key(const Key& secret) {
  SigningKey key;
  PublicKey out{};
  crypto_sign_seed_keypair(out.data(), key.bytes.data(), secret.data());
  return key;
}

PublicKey public_key(const Key& secret) {
  PublicKey out{};
  SigningKey both;
  crypto_sign_seed_keypair(out.data(), both.bytes.data(), secret.data());
  return out;
}

sync::Signature sign(const SigningKey& key, std::span<const std::byte> text) {
  sync::Signature out{};
  crypto_sign_detached(into(out), nullptr, raw(text), text.size(), key.bytes.data());
  return out;
}

bool signed_by(const PublicKey& key, std::span<const std::byte> text, const sync::Signature& signature) {
  return crypto_sign_verify_detached(raw(signature), raw(text), text.size(), key.data()) == 0;
}

std::optional<PairKeys> pair_keys(const Key& session, const Key& secret, const PublicKey& ours,
                                  const PublicKey& theirs) {
  Key shared{};
  Key scalar{};
  PublicKey point{};
  const SigningKey both = signing_key(secret);
  crypto_sign_ed25519_sk_to_curve25519(scalar.data(), both.bytes.data());
  if (crypto_sign_ed25519_pk_to_curve25519(point.data(), theirs.data()) != 0 ||
      crypto_scalarmult(shared.data(), scalar.data(), point.data()) != 0)
    return std::nullopt;
  constexpr std::string_view kName = "padr pair";
  return PairKeys{one_way(session, kName, shared, ours, theirs), one_way(session, kName, shared, theirs, ours)};
}

PublicKey exchange_key(const Key& secret) {
  PublicKey out{};
  crypto_scalarmult_base(out.data(), secret.data());
  return out;
}

std::optional<PairKeys> next_keys(const PairKeys& former, const Key& secret, const PublicKey& ours,
                                  const PublicKey& theirs) {
  Key shared{};
  if (crypto_scalarmult(shared.data(), secret.data(), theirs.data()) != 0) return std::nullopt;
  constexpr std::string_view kName = "padr rekey";
  return PairKeys{one_way(former.out, kName, shared, ours, theirs), one_way(former.in, kName, shared, theirs, ours)};
}

Tag encrypt(const Key& key, std::uint64_t number, std::span<const std::byte> open, std::span<std::byte> text) {
  const Tag tag = tag_of(key, number, open, text);
  mix(key, tag, number, text);
  return tag;
}

bool decrypt(const Key& key, std::uint64_t number, std::span<const std::byte> open, std::span<std::byte> text,
             const Tag& tag) {
  mix(key, tag, number, text);
  return same(tag_of(key, number, open, text), tag);
}

}  // namespace padr::wire
