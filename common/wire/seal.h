#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/model/ids.h"

namespace padr::wire {

using Bytes = std::vector<std::byte>;

inline constexpr std::uint8_t kProtocolVersion = 9;
inline constexpr std::array<std::byte, 2> kDatagramMagic{std::byte{'P'}, std::byte{'d'}};
/// UDP payload at most: fits every path that IPv6 allows (1,280 bytes), if no third peer carries it.
inline constexpr std::size_t kMaxDatagram = 1200;
inline constexpr std::size_t kHeaderBytes = 6;
inline constexpr std::size_t kTagBytes = 4;
inline constexpr std::size_t kMaxPayload = kMaxDatagram - kHeaderBytes - kTagBytes;

enum class Kind : std::uint8_t { kState = 0, kSession = 1, kMembership = 2, kCarried = 3 };

struct Header {
  Kind kind = Kind::kState;
  PeerId sender = kNoPeer;
  std::uint16_t session = 0;  ///< drawn by the founder; 0 before it is known
};

/// Why a datagram was dropped before anything in it was believed.
enum class SealError : std::uint8_t { kNone, kTooShort, kTooLong, kMagic, kVersion, kKind, kTag };

/// Header, payload and tag as one datagram. The payload is at most kMaxPayload bytes; of kCarried as many as
/// wire/carried.h says.
Bytes seal(const Header& header, std::span<const std::byte> payload);
/// The same into `out`, in place of what is there.
void seal(const Header& header, std::span<const std::byte> payload, Bytes& out);

struct Opened {
  Header header;
  std::span<const std::byte> payload;   ///< into the datagram
  std::span<const std::byte> datagram;  ///< as it came
};
/// The datagram's parts if its tag is right, but for kCarried, which is only ever sealed; otherwise nothing, and why.
/// For kVersion the version found is in `version`.
std::optional<Opened> open(std::span<const std::byte> datagram, SealError& error, std::uint8_t* version = nullptr);

}  // namespace padr::wire
