#pragma once

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>

#include "common/model/user_error.h"

namespace padr::scenarios::testing {

/// First of the seeds a test goes through: PADR_TEST_SEED, else 1. Printed, so that a failure can be repeated.
inline std::uint64_t first_seed() {
  const char* given = std::getenv("PADR_TEST_SEED");
  const std::uint64_t seed = given != nullptr ? std::strtoull(given, nullptr, 10) : 1;
  std::cout << "seeds from " << seed << " (PADR_TEST_SEED)\n";
  return seed;
}

/// The message of the UserError that `action` throws; "no error" if it throws none.
template <typename Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const UserError& e) {
    return e.what();
  }
  return "no error";
}

}  // namespace padr::scenarios::testing
