#pragma once

#include <cmath>
#include <cstdint>

namespace padr {

/// Number of a peer in its session, that of its slot: 0 is the founder, until it goes.
using PeerId = std::uint8_t;
inline constexpr PeerId kNoPeer = 0xFF;
/// Avatar slots and peers of one session at most; one byte on the wire, one bit in a PeerSet.
inline constexpr int kMaxPeers = 64;

/// Peers, or the avatars of their slots: bit p stands for slot p.
using PeerSet = std::uint64_t;
constexpr PeerSet only(PeerId p) {
  return PeerSet{1} << p;
}

/// Bodies are 0 .. bodies-1 in scenario order; the avatar of peer p is bodies + p.
using EntityId = std::uint16_t;
inline constexpr EntityId kNoEntity = 0xFFFF;

/// Steps since the session's start. Tick t is the state after t steps; an update "at t" is true before step t -> t+1.
using Tick = std::int32_t;
inline constexpr int kTicksPerSecond = 60;
inline constexpr float kTickSeconds = 1.0F / 60.0F;

/// Microseconds on whatever clock the caller keeps (session time in the core).
using Micros = std::int64_t;
inline constexpr Micros kMicrosPerSecond = 1'000'000;

/// So many seconds, to the nearest microsecond.
inline Micros in_micros(double seconds) {
  return std::llround(seconds * static_cast<double>(kMicrosPerSecond));
}

/// Session time at which tick t begins, rounded down to whole microseconds.
constexpr Micros tick_start(Tick t) {
  return static_cast<Micros>(t) * kMicrosPerSecond / kTicksPerSecond;
}

/// The tick that lasts at this session time, >= 0.
constexpr Tick tick_at(Micros session_time) {
  return static_cast<Tick>(session_time * kTicksPerSecond / kMicrosPerSecond);
}

}  // namespace padr
