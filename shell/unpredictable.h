#pragma once

#include <cstdint>
#include <random>

namespace padr::shell {

/// 64 bits that nobody guesses, from the system.
inline std::uint64_t unpredictable() {
  std::random_device device;
  return std::uint64_t{device()} << 32U | device();
}

}  // namespace padr::shell
