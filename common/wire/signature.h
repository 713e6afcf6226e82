#pragma once

#include <cstdint>
#include <span>

#include "common/sync/updates.h"
#include "common/wire/seal.h"
#include "common/wire/secret.h"

namespace padr::wire {

// Who has said an update: in a session with a key each is signed, so that whoever passes it on can invent none.

/// What a signature binds an update to besides what it says: one life of one peer in one session.
struct Said {
  std::uint16_t session = 0;
  std::uint32_t incarnation = 0;  ///< of the update's peer
};

/// What is signed: WIRE.md, section 14.
Bytes signed_text(const Said& said, const sync::Bundle& update);

sync::Signature sign_update(const SigningKey& key, const Said& said, const sync::Bundle& update);
/// Whether it bears the signature of whoever has this public key.
bool is_signed(const PublicKey& key, const Said& said, const sync::Bundle& update);

}  // namespace padr::wire
