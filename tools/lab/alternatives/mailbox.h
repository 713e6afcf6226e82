#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/wire/seal.h"
#include "tools/lab/alternatives/alternative.h"
#include "tools/lab/alternatives/bits.h"

namespace padr::lab::alternatives {

/// Datagrams of one peer: sealed, opened and counted, the same way for all alternatives.
class Mailbox {
 public:
  explicit Mailbox(const AlternativeConfig& config) : config_(config) {}

  struct Letter {
    PeerId from = 0;
    std::span<const std::byte> payload;  ///< into the datagram
  };
  /// Nothing for what is damaged, of another session, or of nobody else.
  std::optional<Letter> open(std::span<const std::byte> datagram) const;
  void count_dropped() { ++stats_.datagrams_dropped; }

  void begin_tick() { outgoing_.clear(); }
  /// Seals and counts; payload at most wire::kMaxPayload.
  void post(PeerId to, const BitWriter& payload, std::uint64_t states);

  const std::vector<node::Outgoing>& outgoing() const { return outgoing_; }
  const AlternativeStats& stats() const { return stats_; }

 private:
  AlternativeConfig config_;
  std::vector<node::Outgoing> outgoing_;
  AlternativeStats stats_;
};

/// Ticks on the wire are their lowest 16 bits; the tick meant is the one that lies nearest to `now`.
inline constexpr int kTickBits = 16;
Tick whole_tick(std::uint32_t bits, Tick now);

}  // namespace padr::lab::alternatives
