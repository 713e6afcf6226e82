#pragma once

#include <cstdint>
#include <span>

#include "common/sync/transfer.h"
#include "common/wire/seal.h"
#include "common/wire/secret.h"

namespace padr::wire {

// Who has said an update: in a session with a key each is signed, so that whoever passes it on can invent none.

/// The id of a session that this peer founds. `secret`: 32 bytes that no other run of the program has.
SessionId session_id(const Key& secret, const PublicKey& founder, std::uint64_t scene_hash);

/// What a signature binds an update to besides what it says: one life of one peer in one session.
struct Said {
  SessionId session{};
  std::uint32_t incarnation = 0;  ///< of the update's peer
};

/// What is signed: WIRE.md, section 14.
Bytes signed_text(const Said& said, const sync::Bundle& update);

sync::Signature sign_update(const SigningKey& key, const Said& said, const sync::Bundle& update);
/// Whether it bears the signature of whoever has this public key.
bool is_signed(const PublicKey& key, const Said& said, const sync::Bundle& update);

/// Whether no honest peer can have published both: a peer publishes each number once, and at most one update a tick,
/// with numbers that rise with the ticks. Does not look at signatures.
bool contradict(const sync::Bundle& one, const sync::Bundle& other);
/// Whether the two contradict each other, and both are signed with the key.
bool is_proven(const SessionId& session, const sync::Transfer::Proof& proof);

}  // namespace padr::wire
