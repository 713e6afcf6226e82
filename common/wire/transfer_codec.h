#pragma once

#include <optional>
#include <span>

#include "common/model/scene.h"
#include "common/sync/transfer.h"
#include "common/wire/seal.h"

namespace padr::wire {

/// The bytes that go out in pieces.
Bytes encode_transfer(const sync::Transfer& transfer);

/// What another peer says the agreed world is; nothing if it is not well formed, or not one of this scene with so many
/// slots, or has a value that physics cannot take.
std::optional<sync::Transfer> decode_transfer(std::span<const std::byte> bytes, const Scene& scene, int slots);

}  // namespace padr::wire
