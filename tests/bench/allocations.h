#pragma once

#include <cstdint>

namespace padr::bench {

/// Called by counting_new.cpp at every `new`; where they are counted is for the program to choose: allocations.cpp or
/// counted_in_file.cpp.
void count_allocation();

/// Allocations of this program so far, by whatever `new` there is; of allocations.cpp.
std::uint64_t allocations();

}  // namespace padr::bench
