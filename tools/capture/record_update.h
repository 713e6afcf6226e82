#pragma once

#include "common/sync/updates.h"
#include "tools/capture/record.h"

namespace padr::capture {

/// `mark_tick` and `mark_count`: what the update counts back from.
void put_update(Record& r, const sync::Bundle& b, Tick mark_tick, std::uint32_t mark_count);

/// Why every receiver drops updates that are well formed, by proto/WIRE.md, section 4; empty if not, as far as the
/// datagram by itself tells.
std::string_view drop_of(const std::vector<sync::Bundle>& updates);

}  // namespace padr::capture
