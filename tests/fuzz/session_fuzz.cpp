#include <cstdlib>

#include "common/wire/session_codec.h"
#include "tests/fuzz/bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace padr;
  const auto message = wire::decode_session(test::bytes(data, size));
  if (message && !wire::decode_session(wire::encode_session(*message))) std::abort();
  return 0;
}
