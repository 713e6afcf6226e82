#pragma once

#include <cstddef>
#include <cstdint>

#include "common/capture/frame.h"
#include "common/model/endpoint.h"

namespace padr::capture {

/// What became of a frame.
enum class Content : std::uint8_t {
  kUdp,          ///< a whole UDP datagram
  kCutUdp,       ///< the begin of one: the capture did not keep all of it (snaplen)
  kFragment,     ///< of an IP packet that was sent in pieces: left out
  kOther,        ///< no UDP
  kUnknownLink,  ///< a link type that is not understood
  kMalformed,    ///< headers that contradict themselves
  kCutHeaders,   ///< cut off before it could be told what it is (snaplen)
};
inline constexpr std::size_t kContents = 7;

struct UdpDatagram {
  Endpoint from;
  Endpoint to;
  std::span<const std::byte> payload;  ///< into the frame
  std::size_t payload_bytes = 0;       ///< of the whole payload, of which the frame may have less; 0: not known
  std::size_t wire_bytes = 0;          ///< of the IP packet, headers included
};

/// Reads a frame down to the datagram that it carries; `out` has it for kUdp and kCutUdp. UDP checksums are not looked
/// at: the sending machine's own captures have them half done.
Content udp_of(const Frame& frame, UdpDatagram& out);

}  // namespace padr::capture
