#include "common/model/user_error.h"
#include "common/trace/trace_reader.h"
#include "tests/fuzz/bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace padr;
  try {
    trace::TraceReader reader(test::bytes(data, size), "fuzz");
    while (reader.next()) {
    }
  } catch (const UserError&) {
  }
  return 0;
}
