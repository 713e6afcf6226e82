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

using Handshake = std::variant<Hello, Cookie, Introduction, Acceptance>;

/// All are of this size, so no answer is larger than what provoked it.
inline constexpr std::size_t kHandshakeBytes = 76;

/// The key that Hello and Cookie are tagged with, out of the session's.
Key handshake_key(const Key& session);

Bytes encode_handshake(const Hello& hello, const Key& handshake_key);
Bytes encode_handshake(const Cookie& cookie, const Key& handshake_key);
/// `pair`: of the direction in which it goes.
Bytes encode_handshake(const Introduction& introduction, const Key& pair);
Bytes encode_handshake(const Acceptance& acceptance, const Key& pair);

/// Whether it is one, by length, magic, version, kind and type.
bool is_handshake(std::span<const std::byte> datagram);
/// What is said in one. Hello and Cookie only if their tags are right. That of the other two is for whoever knows the
/// pair's key to check: see below.
std::optional<Handshake> decode_handshake(std::span<const std::byte> datagram, const Key& handshake_key);
bool proves(std::span<const std::byte> datagram, const Key& pair, std::uint64_t number);

}  // namespace padr::wire
