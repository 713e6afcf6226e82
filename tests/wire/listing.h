#pragma once

#include <string>

#include "common/sync/transfer.h"
#include "common/wire/codec.h"
#include "common/wire/membership_codec.h"
#include "common/wire/session_codec.h"

namespace padr::test {

/// What our decoder makes of a datagram, in the words of proto/WIRE.md: one `name = value` a line, or `drop = why`.
struct Reading {
  std::string lines;
  wire::Bytes again;  ///< what our encoder makes of that; empty if dropped
};
Reading read(const wire::Bytes& datagram);

/// Of what is in a datagram, without its header.
std::string list(const sync::StatePacket& packet);
std::string list(const wire::SessionMessage& message);
std::string list(const wire::MembershipMessage& message);
std::string list(const sync::Transfer& transfer);
/// `kind`, `sender` and `session`.
std::string list(const wire::Header& header);

/// Two digits a byte, 16 bytes a line.
std::string hex(const wire::Bytes& bytes);

}  // namespace padr::test
