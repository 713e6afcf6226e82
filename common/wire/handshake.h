#pragma once

#include <optional>
#include <variant>

#include "common/wire/sealed.h"

namespace padr::wire {

// How two programs that have a session's key get to know one another's public keys and addresses, before anything else
// is said; proto/WIRE.md, section 14, says who says what to whom.

struct Hello {
  PublicKey key{};
  std::uint64_t nonce = 0;
  friend bool operator==(const Hello&, const Hello&) = default;
};

struct Cookie {
  PublicKey key{};
  std::uint64_t nonce = 0;  ///< of the Hello
  Tag cookie{};
  friend bool operator==(const Cookie&, const Cookie&) = default;
};

struct Introduction {
  PublicKey key{};
  std::uint64_t number = 0;  ///< like that of a sealed datagram
  Tag cookie{};
  friend bool operator==(const Introduction&, const Introduction&) = default;
};

struct Acceptance {
  PublicKey key{};
  std::uint64_t number = 0;
  friend bool operator==(const Acceptance&, const Acceptance&) = default;
};

/// One of two peers has this new public key for their next keys.
struct Rekey {
  PublicKey exchange{};  ///< of X25519, for these next keys only
  std::uint64_t number = 0;
  std::uint32_t id = 0;          ///< short id of the sender
  std::uint32_t generation = 0;  ///< of the next keys: the first keys of a pair are 0
  /// First eight bytes of the receiver's new public key, if the sender has that; otherwise 0.
  std::uint64_t has = 0;
  friend bool operator==(const Rekey&, const Rekey&) = default;
};

using Handshake = std::variant<Hello, Cookie, Introduction, Acceptance, Rekey>;

/// All are of this size, so no answer is larger than what provoked it.
inline constexpr std::size_t kHandshakeBytes = 76;

/// The key that Hello and Cookie are tagged with, out of the session's.
Key handshake_key(const Key& session);

Bytes encode_handshake(const Hello& hello, const Key& handshake_key);
Bytes encode_handshake(const Cookie& cookie, const Key& handshake_key);
/// `pair`: of the direction in which it goes.
Bytes encode_handshake(const Introduction& introduction, const Key& pair);
Bytes encode_handshake(const Acceptance& acceptance, const Key& pair);
/// `pair`: the key before those that it is about.
Bytes encode_handshake(const Rekey& rekey, const Key& pair);
/// What Rekey::has says of a public key.
std::uint64_t beginning_of(const PublicKey& key);

/// Whether it is one, by length, magic, version, kind and type.
bool is_handshake(std::span<const std::byte> datagram);
/// What is said in one. Hello and Cookie only if their tags are right. That of the others is for whoever knows the
/// pair's key to check: see below.
std::optional<Handshake> decode_handshake(std::span<const std::byte> datagram, const Key& handshake_key);
bool proves(std::span<const std::byte> datagram, const Key& pair, std::uint64_t number);

}  // namespace padr::wire
