// A transfer, and what physics makes of one that is taken in: a newcomer believes it whole.
#include <array>
#include <cstdlib>

#include "common/wire/transfer_codec.h"
#include "tests/fuzz/bytes.h"
#include "tests/fuzz/good.h"
#include "tests/wire/samples.h"

namespace {

const padr::test::Played& played() {
  static const padr::test::Played kPlayed(1);
  return kPlayed;
}

}  // namespace

// Playing takes a thousand times as long as decoding, so there are only so many.
padr::wire::Bytes padr::test::good_input(Rng& rng) {
  constexpr Tick kDifferent = 16;
  static std::array<wire::Bytes, kDifferent> made;
  const auto n = static_cast<Tick>(rng.below(kDifferent));
  wire::Bytes& good = made[static_cast<std::size_t>(n)];
  if (good.empty()) good = wire::encode_transfer(Played(1, 30 + n * 13).transfer());
  return good;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace padr;
  constexpr int kSlots = test::Played::kSlots;
  const Scene& scene = played().scene();
  const auto transfer = wire::decode_transfer(test::bytes(data, size), scene, kSlots);
  if (!transfer) return 0;
  const wire::Bytes again = wire::encode_transfer(*transfer);
  const auto back = wire::decode_transfer(again, scene, kSlots);
  if (!back || wire::encode_transfer(*back) != again) std::abort();
  sync::AgreedWorld world(scene, {kSlots, 0, 2, true, true, {}}, *transfer, {});
  for (const sync::Bundle& b : transfer->tail) world.insert(b);
  for (int i = 0; i < 3 && transfer->state.tick < 1 << 30; ++i) world.step();
  return 0;
}
