#include <cstdlib>
#include <string>
#include <vector>

#include "common/link/netem_spec.h"
#include "common/model/user_error.h"
#include "shell/netem_text.h"
#include "tests/fuzz/bytes.h"

namespace {

using namespace padr;

/// What is accepted reads back as itself.
void check(const std::string& text, const shell::ReadFile& read) {
  try {
    std::vector<std::string> warnings;
    const link::NetemSpec spec = shell::parse_netem(text, &warnings, read);
    if (!(shell::parse_netem(shell::to_string(spec), nullptr, read) == spec)) std::abort();
  } catch (const UserError&) {
  }
}

}  // namespace

/// The bytes as a specification, and as the file of a link trace.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(test::text(data, size));
  check(text, {});
  check("trace file", [&text](const std::string&) { return text; });
  return 0;
}
