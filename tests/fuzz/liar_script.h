#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/participant/participant.h"
#include "common/wire/codec.h"
#include "common/wire/membership_codec.h"
#include "common/wire/session_codec.h"

namespace padr::test {

/// One step of a liar's script: something that a member may say, with values that may be anything.
struct LieEntry {
  static constexpr std::size_t kBytes = 12;
  static constexpr std::size_t kValues = 9;
  static constexpr std::uint32_t kKinds = 24;  ///< of `what`, modulo this
  std::uint8_t what = 0;
  std::uint8_t to = 0;     ///< bit p: member p is told
  std::uint8_t turns = 0;  ///< until the next entry
  std::array<std::uint8_t, kValues> v{};
};

std::vector<LieEntry> lie_script(std::span<const std::uint8_t> bytes, std::size_t most);

/// What a liar knows, and can sign with.
struct LiarsKnowledge {
  const node::Replica& replica;
  const wire::SigningKey& key;
};

/// Whether the entry changes a state datagram; otherwise it is a datagram of its own.
bool is_of_state(const LieEntry& e);
/// Changes a state packet, and signs what it changes.
void lie(sync::StatePacket& packet, const LieEntry& e, const LiarsKnowledge& with);
/// The unsealed datagram that an entry says; nothing if it has no form on the wire.
std::optional<wire::Bytes> lie(const LieEntry& e, const LiarsKnowledge& with);

}  // namespace padr::test
