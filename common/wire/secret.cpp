#include "common/wire/secret.h"

#include <sodium.h>

#include <algorithm>
#include <cassert>
#include <utility>

namespace padr::wire {
namespace {

static_assert(crypto_scalarmult_BYTES == sizeof(Key) && crypto_scalarmult_SCALARBYTES == sizeof(Key));
static_assert(crypto_sign_SEEDBYTES == sizeof(Key) && crypto_sign_PUBLICKEYBYTES == sizeof(PublicKey));
static_assert(crypto_sign_SECRETKEYBYTES == sizeof(SigningKey) && crypto_sign_BYTES == sizeof(sync::Signature));
static_assert(crypto_aead_xchacha20poly1305_ietf_KEYBYTES == sizeof(Key));
static_assert(crypto_aead_xchacha20poly1305_ietf_ABYTES == sizeof(Tag));

constexpr std::size_t kNonceBytes = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES;

const unsigned char* raw(std::span<const std::byte> bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

unsigned char* into(std::span<std::byte> bytes) {
  return reinterpret_cast<unsigned char*>(bytes.data());
}

std::array<unsigned char, kNonceBytes> nonce_of(std::uint64_t number) {
  std::array<unsigned char, kNonceBytes> nonce{};
  for (unsigned i = 0; i < 8; ++i) nonce[i] = static_cast<unsigned char>(number >> (8 * i));
  return nonce;
}

}  // namespace

void choose_fast_code() {
  const int result = sodium_init();
  assert(result >= 0);
  static_cast<void>(result);
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
  std::array<unsigned char, crypto_sign_SECRETKEYBYTES> both{};
  crypto_sign_seed_keypair(out.data(), both.data(), secret.data());
  sodium_memzero(both.data(), both.size());
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
  SigningKey both = signing_key(secret);
  crypto_sign_ed25519_sk_to_curve25519(scalar.data(), both.bytes.data());
  const bool usable = crypto_sign_ed25519_pk_to_curve25519(point.data(), theirs.data()) == 0 &&
                      crypto_scalarmult(shared.data(), scalar.data(), point.data()) == 0;
  sodium_memzero(both.bytes.data(), both.bytes.size());
  sodium_memzero(scalar.data(), scalar.size());
  if (!usable) return std::nullopt;
  const auto one_way = [&](const PublicKey& from, const PublicKey& to) {
    constexpr std::string_view kName = "padr pair";
    std::array<unsigned char, kName.size() + 3 * sizeof(Key)> text{};
    auto* at = std::copy(kName.begin(), kName.end(), text.begin());
    for (const Key* part : {&std::as_const(shared), &from, &to}) at = std::copy(part->begin(), part->end(), at);
    Key out{};
    crypto_generichash(out.data(), out.size(), text.data(), text.size(), session.data(), session.size());
    sodium_memzero(text.data(), text.size());
    return out;
  };
  const PairKeys keys{one_way(ours, theirs), one_way(theirs, ours)};
  sodium_memzero(shared.data(), shared.size());
  return keys;
}

Tag encrypt(const Key& key, std::uint64_t number, std::span<const std::byte> open, std::span<std::byte> text) {
  Tag tag{};
  std::array<std::byte, 1> nothing{};
  if (text.empty()) text = std::span(nothing).first(0);  // the library takes no null, not even for nothing
  const auto nonce = nonce_of(number);
  crypto_aead_xchacha20poly1305_ietf_encrypt_detached(into(text), into(tag), nullptr, raw(text), text.size(), raw(open),
                                                      open.size(), nullptr, nonce.data(), key.data());
  return tag;
}

bool decrypt(const Key& key, std::uint64_t number, std::span<const std::byte> open, std::span<std::byte> text,
             const Tag& tag) {
  std::array<std::byte, 1> nothing{};
  if (text.empty()) text = std::span(nothing).first(0);
  const auto nonce = nonce_of(number);
  return crypto_aead_xchacha20poly1305_ietf_decrypt_detached(into(text), nullptr, raw(text), text.size(), raw(tag),
                                                             raw(open), open.size(), nonce.data(), key.data()) == 0;
}

}  // namespace padr::wire
