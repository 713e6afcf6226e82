#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/session/view.h"
#include "common/sync/packet.h"
#include "common/sync/transfer.h"

namespace padr::node {

/// Whoever has published an update.
struct Sayer {
  std::uint32_t incarnation = 0;
  PublicKey key{};
};

/// Peers admitted by orders that wait for earlier ones, and earlier in the datagram that is being judged, in order.
using Admitted = std::vector<const sync::Admission*>;

enum class Signed : std::uint8_t {
  kYes,
  kNo,
  kUnclear,  ///< not by the peer that we know; the admission of a newer one may be on its way
};

/// The peer that published the slot's update of that number; nothing if it is not known.
std::optional<Sayer> sayer(PeerId p, std::uint32_t index, const View& view, const Admitted& meanwhile);
/// The peer whose valid signature a new update lacks; nothing if it has one, or if the peer is not known.
std::optional<Sayer> missing_signer(const sync::Bundle& b, const View& view, const Admitted& meanwhile);
/// Whether an update and those that it passes on are signed. Adds admissions to `meanwhile`.
Signed is_signed(const sync::Bundle& b, bool passed_on, const View& view, Admitted& meanwhile);
/// Admissions that are here and wait for an update before them. Only what is passed on may be of such a newcomer: none
/// if the packet passes nothing on.
std::vector<sync::Bundle> waiting_admissions(const sync::StatePacket& packet, const View& view);
/// Signatures that have to be checked for an update and those that it passes on.
int signatures_in(const sync::Bundle& b, const View& view);
/// Whether the updates in a transfer have valid signatures, as far as the transfer has the keys.
bool said(const sync::Transfer& transfer, const SessionId& session);

}  // namespace padr::node
