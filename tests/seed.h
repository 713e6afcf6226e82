#pragma once

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>

namespace padr::test {

/// The seed of randomised tests: PADR_TEST_SEED from the environment, else `otherwise`; printed.
inline std::uint64_t seed(std::uint64_t otherwise = 20240607) {
  const char* text = std::getenv("PADR_TEST_SEED");
  const std::uint64_t s = text != nullptr ? std::stoull(text) : otherwise;
  std::cout << "seed " << s << " (PADR_TEST_SEED)\n";
  return s;
}

}  // namespace padr::test
