#pragma once

// What the codecs of both directions share; nobody else includes it.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "common/monitor/codec.h"
#include "proto/monitor.pb.h"

namespace padr::monitor {

inline constexpr std::string_view kPreamble{"PMON\1", 5};
/// What protobuf may take of a datagram.
inline constexpr std::size_t kRoom = kMostBytes - kPreamble.size();

inline Bytes to_bytes(const file::Datagram& d) {
  const std::size_t size = d.ByteSizeLong();
  Bytes bytes(kPreamble.size() + size);
  std::memcpy(bytes.data(), kPreamble.data(), kPreamble.size());
  d.SerializeToArray(bytes.data() + kPreamble.size(), static_cast<int>(size));
  return bytes;
}

inline bool from_bytes(std::span<const std::byte> datagram, file::Datagram& d) {
  if (datagram.size() < kPreamble.size() || datagram.size() > kMostBytes ||
      std::memcmp(datagram.data(), kPreamble.data(), kPreamble.size()) != 0)
    return false;
  const auto rest = datagram.subspan(kPreamble.size());
  return d.ParseFromArray(rest.data(), static_cast<int>(rest.size()));
}

inline std::string cut_text(std::string_view text) {
  return std::string(text.substr(0, kMostText));
}
/// False if it is too long.
inline bool take_text(const std::string& in, std::string& out) {
  out = in;
  return in.size() <= kMostText;
}

inline std::uint32_t put_slot(PeerId p) {
  return p == kNoPeer ? 0U : p + 1U;
}
inline bool take_slot(std::uint32_t in, PeerId& out) {
  out = in == 0 ? kNoPeer : static_cast<PeerId>(in - 1);
  return in <= static_cast<std::uint32_t>(kMaxPeers);
}

inline bool take_tick(std::uint32_t in, Tick& out) {
  out = static_cast<Tick>(in);
  return in < static_cast<std::uint32_t>(std::numeric_limits<Tick>::max());
}

/// NaN is in no range.
inline bool take_between(float in, float least, float most, float& out) {
  out = in;
  return in >= least && in <= most;
}

}  // namespace padr::monitor
