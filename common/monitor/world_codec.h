#pragma once

// Frames and agreed worlds, for the codec; nobody else includes it.

#include "common/monitor/format.h"

namespace padr::monitor {

/// Appends as many datagrams as it takes, each with `from`.
void put_world(const file::Origin& from, const Frame& frame, std::vector<Bytes>& out);
void put_world(const file::Origin& from, const Agreed& agreed, std::vector<Bytes>& out);
bool take_world(const file::Frame& in, Frame& out);
bool take_world(const file::Agreed& in, Agreed& out);

}  // namespace padr::monitor
