#pragma once

#include "common/model/rng.h"
#include "common/monitor/orders.h"
#include "common/monitor/telemetry.h"

namespace padr::test {

// Any message that the codec can carry, with what is told rounded as it is told: it comes back as it was.

monitor::Origin any_origin(Rng& rng);
/// Kind 0 .. 5, in the order of the variant.
monitor::Message any_message(Rng& rng, std::uint32_t kind);
monitor::Frame any_frame(Rng& rng, EntityId entities, int views);
monitor::Order any_order(Rng& rng);

}  // namespace padr::test
