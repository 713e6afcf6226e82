// The payload of a membership datagram.
#include <algorithm>
#include <cstdlib>

#include "tests/fuzz/bytes.h"
#include "tests/fuzz/good.h"
#include "tests/wire/samples.h"

padr::wire::Bytes padr::test::good_input(Rng& rng) {
  return wire::encode_membership(any_membership(rng, rng.below(kMembershipKinds)));
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace padr;
  const auto message = wire::decode_membership(test::bytes(data, size));
  if (!message) return 0;
  // What decodes is what encoding it again gives, and fits a datagram.
  const wire::Bytes bytes = wire::encode_membership(*message);
  const auto again = wire::decode_membership(bytes);
  if (!again || again->index() != message->index()) std::abort();
  if (const auto* fetched = std::get_if<wire::Fetched>(&*message)) {  // as many updates as fit
    const auto& some = std::get<wire::Fetched>(*again);
    if (some.updates.empty() || some.updates.size() > fetched->updates.size()) std::abort();
  } else if (bytes.size() > wire::kMaxPayload) {
    std::abort();
  }
  return 0;
}
