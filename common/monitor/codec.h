#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "common/monitor/orders.h"
#include "common/monitor/telemetry.h"

namespace padr::monitor {

// Structs to datagrams and back; proto/monitor.proto has the format. Alone in knowing the generated code.

using Bytes = std::vector<std::byte>;

/// No datagram is longer.
inline constexpr std::size_t kMostBytes = 1200;
/// Longer texts are cut when they are told, and make a datagram malformed.
inline constexpr std::size_t kMostText = 400;
/// Bytes of scenario text in a piece, and of a whole one; a longer one is not told.
inline constexpr std::size_t kMostPart = 1000;
inline constexpr std::size_t kMostScenario = 256 * 1024;
/// Events of one datagram.
inline constexpr std::size_t kMostEvents = 16;
/// Farther from the origin than this, in metres, is no place: entities are told there at most.
inline constexpr float kMostMetres = 1.0e6F;
/// Longest cut or pause, s.
inline constexpr float kMostSeconds = 600;

/// As many datagrams as it takes: frames and agreed worlds in ranges of entities, a status with its links in turn. Of
/// events the newest that fit.
std::vector<Bytes> encode(const Origin& from, const Message& message);
/// Nothing if it is not well formed, or has a value out of its range.
std::optional<Told> decode_told(std::span<const std::byte> datagram);

Bytes encode(const Order& order);
std::optional<Order> decode_order(std::span<const std::byte> datagram);

}  // namespace padr::monitor
