#pragma once

#include <string>

#include "tests/membership/party.h"

namespace padr::test {

/// Play waits for `wanted`, but only `at_once` start.
inline Party waiting(int wanted, int at_once, const std::string& netem = "delay 10ms", std::uint64_t seed = 1) {
  return Party(party_config(wanted, netem, seed), {}, at_once);
}

}  // namespace padr::test
