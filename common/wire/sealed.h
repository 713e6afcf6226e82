#pragma once

#include <optional>

#include "common/wire/seal.h"
#include "common/wire/secret.h"

namespace padr::wire {

/// What a session's key does to datagrams.
enum class SealMode : std::uint8_t {
  kNone = 0,     ///< nothing: a checksum finds damage, and nothing proves who sends
  kAuth = 1,     ///< readable by all, made by none but its sender
  kEncrypt = 2,  ///< and readable by none but its receiver
};

// A sealed datagram is an unsealed one with 8 bytes between header and payload, who sends it and its number, and
// another tag in place of the checksum.
inline constexpr std::size_t kSealedHeaderBytes = kHeaderBytes + 8;
inline constexpr std::size_t kSealedTagBytes = sizeof(Tag);
/// So many bytes longer than unsealed.
inline constexpr std::size_t kSealGrowth = kSealedHeaderBytes + kSealedTagBytes - kHeaderBytes - kTagBytes;
inline constexpr std::size_t kMaxSealed = kMaxDatagram + kSealGrowth;
/// A datagram of Kind::kCarried has another sealed one in it, behind a short id.
inline constexpr std::size_t kCarriedHeaderBytes = 4;
inline constexpr std::size_t kMaxCarriedPayload = kCarriedHeaderBytes + kMaxSealed;
inline constexpr std::size_t kMaxCarried = kSealedHeaderBytes + kMaxCarriedPayload + kSealedTagBytes;

/// The first four bytes of a public key, little endian: by this a receiver finds the key to check with.
std::uint32_t short_id(const PublicKey& key);

/// What a sealed datagram says of itself; believable once its tag has been checked.
struct SealedHeader {
  Kind kind = Kind::kState;
  SealMode mode = SealMode::kAuth;
  std::uint32_t id = 0;      ///< of the sender
  std::uint32_t number = 0;  ///< lower half
};

/// By length, magic, version, kind and mode a sealed datagram of this version.
std::optional<SealedHeader> read_sealed(std::span<const std::byte> datagram);

/// An unsealed datagram of our own making, sealed. `id`: ours. A key sees each number once.
Bytes seal_with(const Key& key, SealMode mode, std::uint32_t id, std::uint64_t number,
                std::span<const std::byte> unsealed);
/// The same into `out`, in place of what is there.
void seal_with(const Key& key, SealMode mode, std::uint32_t id, std::uint64_t number,
               std::span<const std::byte> unsealed, Bytes& out);
/// The unsealed datagram in one that read_sealed takes, if the tag is right; its number's upper half is told by the
/// caller.
std::optional<Bytes> unseal_with(const Key& key, std::uint64_t number, std::span<const std::byte> sealed);
/// The same into `out`, in place of what is there; false, and `out` is worth nothing, if the tag is another.
bool unseal_with(const Key& key, std::uint64_t number, std::span<const std::byte> sealed, Bytes& out);
/// The same for those who have no key: unchecked, and only of what is readable.
std::optional<Bytes> unseal_unchecked(std::span<const std::byte> sealed);

/// Payload of a datagram of Kind::kCarried: one that a member passes on for two others whose own link does not work.
struct Carried {
  std::uint32_t to = 0;               ///< short id of whom it is sealed for
  std::span<const std::byte> sealed;  ///< 10 .. kMaxSealed bytes
};
/// The unsealed datagram, into `out`, in place of what is there. Its header is that of the datagram that it carries.
void encode_carried(const Carried& carried, Bytes& out);
/// Of an unsealed datagram of Kind::kCarried.
std::optional<Carried> decode_carried(std::span<const std::byte> unsealed);

}  // namespace padr::wire
