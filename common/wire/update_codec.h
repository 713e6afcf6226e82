#pragma once

#include "common/sync/updates.h"

namespace padr::wire {

class Update;

/// `mark_tick` and `mark_count`: what the numbers in the message count back from; not below the bundle's own.
void put_update(const sync::Bundle& bundle, Tick mark_tick, std::uint32_t mark_count, Update& out);
/// False if it is not well formed; see StateDecoder. Whatever `out` was is overwritten, but its peer, which is the
/// caller's to fill in; its memory is used again.
bool take_update(const Update& in, Tick mark_tick, std::uint32_t mark_count, sync::Bundle& out);

}  // namespace padr::wire
