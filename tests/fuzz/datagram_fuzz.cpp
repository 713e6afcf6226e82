// A sealed datagram as it comes from the network, and a payload as if its seal had been right.
#include <cstdlib>

#include "common/sync/validation.h"
#include "common/wire/codec.h"
#include "tests/fuzz/bytes.h"
#include "tests/fuzz/good.h"
#include "tests/wire/samples.h"

padr::wire::Bytes padr::test::good_input(Rng& rng) {
  return wire::encode(any_packet(rng, 1));
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace padr;
  wire::SealError error{};
  wire::open(test::bytes(data, size), error);
  const auto packet = wire::decode_state(test::bytes(data, size), 1);
  if (!packet) return 0;
  // What decodes is what encoding it again gives.
  const auto again = wire::decode_state(wire::encode(*packet), 1);
  if (!again || again->updates.size() != packet->updates.size()) std::abort();
  static const Scene kScene = [] {
    Scene s;
    s.bodies.resize(60);
    return s;
  }();
  sync::admit(*packet, kScene, kMaxPeers, 1000);
  return 0;
}
