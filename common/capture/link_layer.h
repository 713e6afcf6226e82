#pragma once

#include <cstdint>
#include <optional>

#include "common/capture/byte_order.h"

namespace padr::capture {

/// The IP packet within a frame of this link type; empty if the frame carries something else or ends before; nothing
/// if the link type is not known.
std::optional<ByteView> ip_of(std::uint32_t link_type, ByteView frame);

}  // namespace padr::capture
