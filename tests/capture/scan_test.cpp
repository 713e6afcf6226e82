#include <gtest/gtest.h>

#include "common/wire/codec.h"
#include "common/wire/state_scan.h"
#include "tests/seed.h"
#include "tests/wire/samples.h"

namespace padr {
namespace {

void expect_same(const sync::StatePacket& p, const wire::StateScan& s) {
  EXPECT_EQ(s.seq, p.seq);
  EXPECT_EQ(s.mark_tick, static_cast<std::uint32_t>(p.mark_tick));
  EXPECT_EQ(s.mark_count, p.mark_count);
  EXPECT_EQ(s.have, p.have);
  EXPECT_EQ(s.have_beyond, p.have_beyond);
  EXPECT_EQ(s.seen_seq, p.seen_seq);
  EXPECT_EQ(s.seen_age, p.seen_age);
  EXPECT_EQ(s.transit, p.transit);
  EXPECT_EQ(s.loss, p.loss);
  EXPECT_EQ(s.incarnation, p.incarnation);
  EXPECT_EQ(s.to_incarnation, p.to_incarnation);
  EXPECT_EQ(s.check_hash, p.check_hash);
  ASSERT_EQ(s.updates.size(), p.updates.size());
  for (std::size_t i = 0; i < p.updates.size(); ++i) {
    const sync::Bundle& b = p.updates[i];
    std::array<std::uint8_t, sync::kCauses> causes{};
    if (b.avatar) ++causes[static_cast<std::size_t>(b.avatar->cause)];
    for (const sync::BodyUpdate& u : b.bodies) ++causes[static_cast<std::size_t>(u.cause)];
    EXPECT_EQ(s.updates[i].index, b.index);
    EXPECT_EQ(s.updates[i].tick, static_cast<std::uint32_t>(b.tick));
    EXPECT_EQ(s.updates[i].causes, causes);
    EXPECT_EQ(s.updates[i].leave, b.leave);
    EXPECT_EQ(s.updates[i].order, b.admission.has_value() || !b.removals.empty() || !b.passed_on.empty());
  }
}

TEST(StateScan, ReadsWhatTheDecoderReads) {
  Rng rng(test::seed());
  wire::StateScan scan;  // used again and again, as programs do
  for (int i = 0; i < 2000; ++i) {
    const sync::StatePacket p = test::any_packet(rng, 3);
    const wire::Bytes bytes = wire::encode(p);
    ASSERT_TRUE(wire::scan_state(bytes, scan));
    expect_same(p, scan);
    std::size_t updates = 0;
    for (const auto& u : scan.updates) updates += u.bytes;
    EXPECT_LE(updates, bytes.size());
  }
}

TEST(StateScan, TakesWhateverTheDecoderTakes) {
  Rng rng(test::seed());
  wire::StateScan scan;
  int taken = 0;
  for (int i = 0; i < 30000; ++i) {
    wire::Bytes bytes = wire::encode(test::any_packet(rng, 3));
    const auto size = static_cast<std::uint32_t>(bytes.size());
    for (std::uint64_t n = rng.below(3) + 1; n > 0 && !bytes.empty(); --n)
      bytes[rng.below(size)] ^= static_cast<std::byte>(1U << rng.below(8));
    if (rng.chance(0.2)) bytes.resize(rng.below(size + 1));
    const bool scanned = wire::scan_state(bytes, scan);
    const auto p = wire::decode_state(bytes, 3);
    if (!p) continue;
    ++taken;
    ASSERT_TRUE(scanned);
    expect_same(*p, scan);
  }
  EXPECT_GT(taken, 1000);
}

}  // namespace
}  // namespace padr
