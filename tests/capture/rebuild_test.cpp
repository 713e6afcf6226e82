#include "tools/capture/rebuild.h"

#include <gtest/gtest.h>

#include "common/scenarios/scenarios.h"
#include "common/sync/state_hash.h"
#include "common/wire/transfer_codec.h"

namespace padr::capture {
namespace {

// Whoever is let in late is told hashes of ticks from before the transfer. Once they counted as not reached, and a
// capture with datagrams of other pairs' keys as one that lacked something.
TEST(Rebuild, HashesOfBeforeTheFirstTransferAreNotMissed) {
  constexpr int kSlots = 4;
  Setting setting;
  setting.scene = scenarios::load_embedded("arena", 1);
  setting.slots = kSlots;
  sync::Fold fold(setting.scene, kSlots, 1, true);
  while (fold.tick() < 40) fold.step();
  sync::Transfer t;
  fold.save(t.state);
  t.slots.resize(kSlots);
  t.have.resize(kSlots);
  const std::uint32_t good = static_cast<std::uint32_t>(sync::hash_of(t.state)) | 1U;
  SessionLog session_log;
  session_log.transfers[{}].parts = {wire::encode_transfer(t)};
  session_log.newest = 60;
  session_log.voices[{0, 0}].marks[0] = 45;
  session_log.checks = {{30, 1, {0, 0}, 1}, {40, good, {0, 0}, 2}, {50, 1, {0, 0}, 3}};
  const Rebuilt r = rebuild(session_log, setting, 0, [](const sync::FoldState&, std::uint64_t) {});
  ASSERT_EQ(r.stretches.size(), 1U);
  EXPECT_EQ(r.stretches[0].from, 40);
  EXPECT_LT(r.stretches[0].to, 50);
  EXPECT_EQ(r.hashes.size(), 1U);
  EXPECT_EQ(r.agreeing(), 1U);
  EXPECT_EQ(r.before, 1U);
  EXPECT_EQ(r.unreached, 1U);
}

}  // namespace
}  // namespace padr::capture
