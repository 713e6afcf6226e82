#include "common/model/user_error.h"
#include "common/scenarios/scenarios.h"
#include "tests/fuzz/bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace padr;
  try {
    scenarios::load(test::text(data, size), "fuzz", 1);
  } catch (const UserError&) {
  }
  return 0;
}
