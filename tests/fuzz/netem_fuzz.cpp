#include <cstdlib>
#include <string>
#include <vector>

#include "common/link/netem_spec.h"
#include "common/model/user_error.h"
#include "shell/netem_text.h"
#include "tests/fuzz/bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace padr;
  try {
    std::vector<std::string> warnings;
    const link::NetemSpec spec = shell::parse_netem(test::text(data, size), &warnings);
    if (!(shell::parse_netem(shell::to_string(spec)) == spec)) std::abort();
  } catch (const UserError&) {
  }
  return 0;
}
