#include <cstdlib>
#include <string>
#include <vector>

#include "common/link/netem_spec.h"
#include "common/model/user_error.h"
#include "tests/fuzz/bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace padr;
  try {
    std::vector<std::string> warnings;
    const link::NetemSpec spec = link::parse_netem(test::text(data, size), &warnings);
    if (!(link::parse_netem(link::to_string(spec)) == spec)) std::abort();
  } catch (const UserError&) {
  }
  return 0;
}
