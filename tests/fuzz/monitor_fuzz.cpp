// A datagram to a monitor and the same bytes as one to a peer.
#include <cstdlib>

#include "common/monitor/codec.h"
#include "tests/fuzz/bytes.h"
#include "tests/fuzz/good.h"
#include "tests/monitor/samples.h"

padr::wire::Bytes padr::test::good_input(Rng& rng) {
  if (rng.chance(0.4)) return monitor::encode(any_order(rng));
  const auto datagrams = monitor::encode(any_origin(rng), any_message(rng, rng.below(6)));
  return datagrams[rng.below(static_cast<std::uint32_t>(datagrams.size()))];
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace padr;
  const auto bytes = test::bytes(data, size);
  // What decodes is what encoding it again gives, in as many datagrams as that takes.
  if (const auto told = monitor::decode_told(bytes)) {
    for (const monitor::Bytes& d : monitor::encode(told->from, told->message)) {
      if (d.size() > monitor::kMostBytes) std::abort();
      const auto again = monitor::decode_told(d);
      if (!again || again->from != told->from || again->message.index() != told->message.index()) std::abort();
    }
  }
  if (const auto order = monitor::decode_order(bytes)) {
    const auto again = monitor::decode_order(monitor::encode(*order));
    if (!again || *again != *order) std::abort();
  }
  return 0;
}
