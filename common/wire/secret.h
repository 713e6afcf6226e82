#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "common/model/endpoint.h"
#include "common/sync/updates.h"

namespace padr::wire {

// What there is of cryptography, all of it libsodium's; nobody else calls that. Nothing here is random: whoever calls
// brings what has to be unpredictable.

/// Overwrites what is no longer needed; no compiler leaves that out.
void wipe(std::span<std::byte> bytes);

/// 32 secret bytes. They are wiped when the object ends; a copy is another object.
struct Key : std::array<std::uint8_t, 32> {
  ~Key() { wipe(std::as_writable_bytes(std::span<std::uint8_t>(*this))); }
};
using Tag = std::array<std::byte, 16>;

/// Lets libsodium look at the processor and choose faster code with the same results. Once, before anything else here.
void choose_fast_code();

/// BLAKE2b-256 of `name`, keyed with `secret`: keys for several purposes out of one.
Key derive_key(const Key& secret, std::string_view name);

/// BLAKE2b-128, keyed.
Tag tag_of(const Key& key, std::span<const std::byte> bytes);
/// In a time that does not depend on where they differ.
bool same(const Tag& a, const Tag& b);

/// Ed25519: whoever has the secret signs, and anybody who has the public key can check. X25519 of both, for the keys of
/// pairs, is made of them.
PublicKey public_key(const Key& secret);

/// A secret and its public key, as signing takes them.
struct SigningKey {
  std::array<std::uint8_t, 64> bytes{};
  ~SigningKey() { wipe(std::as_writable_bytes(std::span(bytes))); }
};
SigningKey signing_key(const Key& secret);
sync::Signature sign(const SigningKey& key, std::span<const std::byte> text);
bool signed_by(const PublicKey& key, std::span<const std::byte> text, const sync::Signature& signature);

/// For what goes from us to another and for what comes from there.
struct PairKeys {
  Key out{};
  Key in{};
  friend bool operator==(const PairKeys&, const PairKeys&) = default;
};
/// The keys of two peers of a session: BLAKE2b-256, keyed with the session's key, of "padr pair", what X25519 makes of
/// our secret and their public key, the sender's public key and the receiver's. Nothing if theirs is no point of the
/// curve, or one that X25519 cannot use.
std::optional<PairKeys> pair_keys(const Key& session, const Key& secret, const PublicKey& ours,
                                  const PublicKey& theirs);

/// The public key of X25519 that belongs to 32 random bytes.
PublicKey exchange_key(const Key& secret);
/// The next keys of two peers, each made of the former one of its direction: BLAKE2b-256, keyed with that, of "padr
/// rekey", what X25519 makes of our new secret and their new public key, and the new public keys of sender and
/// receiver. Nothing if theirs is one that X25519 cannot use.
std::optional<PairKeys> next_keys(const PairKeys& former, const Key& secret, const PublicKey& ours,
                                  const PublicKey& theirs);

/// A synthetic initialisation vector (as in RFC 5297), of BLAKE2b and XChaCha20. The tag is BLAKE2b-128, keyed, of
/// `open`, `text` and `number`; the nonce that hides `text` is the tag and the number. So one nonce never hides two
/// texts, even if a number is used twice. Encrypts `text` in place; `open` stays as it is. Either may be empty.
Tag encrypt(const Key& key, std::uint64_t number, std::span<const std::byte> open, std::span<std::byte> text);
/// The way back; false, and `text` is worth nothing, if the tag is another.
bool decrypt(const Key& key, std::uint64_t number, std::span<const std::byte> open, std::span<std::byte> text,
             const Tag& tag);

}  // namespace padr::wire
