#include "common/model/user_error.h"
#include "common/scenarios/path.h"
#include "shell/path_csv.h"
#include "tests/fuzz/bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace padr;
  try {
    const scenarios::Path path = shell::parse_path_csv(test::text(data, size), "fuzz");
    path.at(path.duration() / 2, true);
  } catch (const UserError&) {
  }
  return 0;
}
