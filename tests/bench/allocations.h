#pragma once

#include <cstdint>

namespace padr::bench {

/// Allocations of this program so far, by whatever `new` there is; counted by allocations.cpp.
std::uint64_t allocations();

}  // namespace padr::bench
