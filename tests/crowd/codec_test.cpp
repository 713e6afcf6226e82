// Passages and residents on the wire.
#include <gtest/gtest.h>

#include "common/crowd/regions.h"
#include "common/sync/state_hash.h"
#include "common/wire/codec.h"
#include "common/wire/transfer_codec.h"

namespace padr::wire {
namespace {

sync::StatePacket packet_with(std::vector<sync::Passage> passages) {
  sync::StatePacket p;
  p.seq = 1;
  p.mark_tick = 100;
  p.mark_count = 1;
  sync::Bundle b;
  b.peer = 3;
  b.tick = 100;
  b.passages = std::move(passages);
  p.updates.push_back(std::move(b));
  return p;
}

sync::Passage entry() {
  sync::Passage p;
  p.kind = sync::Passage::Kind::kIn;
  p.name = {0x80017FFFU, 29};
  p.crossings = 4;
  p.build = 2;
  p.owned = true;
  p.state = {{1.5F, -2}, 0.25F, {3, 4}, -1, true};
  return p;
}

TEST(PassageCodec, ComesOutAsItWentIn) {
  sync::Passage asleep = entry();
  asleep.name.number = 30;
  asleep.owned = false;
  asleep.state.awake = false;
  asleep.state.velocity = {};
  asleep.state.spin = 0;
  sync::Passage out;
  out.kind = sync::Passage::Kind::kOut;
  out.name = {1, 2};
  out.crossings = 9;
  sync::Passage bound;
  bound.to = 77;
  const sync::StatePacket p = packet_with({entry(), asleep, out, bound});
  const auto again = decode_state(encode(p), 3);
  ASSERT_TRUE(again);
  EXPECT_EQ(*again, p);
}

// What is reckoned with when datagrams are filled: more than fits would be sent otherwise.
TEST(PassageCodec, TakesNoMoreBytesThanReckoned) {
  const std::size_t none = encode(packet_with({})).size();
  sync::StatePacket p = packet_with({});
  while (p.updates[0].passages.size() < sync::kMaxPassages) {
    p.updates[0].passages.push_back(entry());
    EXPECT_LE(encode(p).size() - none, encoded_size(p.updates[0])) << p.updates[0].passages.size();
  }
  sync::StatePacket going = packet_with({});
  going.updates[0].going = true;
  EXPECT_LE(encode(going).size() - none, encoded_size(going.updates[0]));
}

TEST(PassageCodec, TheMostThatGoIntoOneUpdateFitADatagram) {
  const sync::StatePacket p = packet_with(std::vector<sync::Passage>(sync::kMaxPassages, entry()));
  EXPECT_LE(encode(p).size(), kMaxPayload);
  EXPECT_TRUE(decode_state(encode(p), 3));
  const sync::StatePacket more = packet_with(std::vector<sync::Passage>(sync::kMaxPassages + 1, entry()));
  EXPECT_FALSE(decode_state(encode(more), 3));
}

TEST(PassageCodec, IsAnUpdateOfItsOwn) {
  sync::StatePacket p = packet_with({entry()});
  p.updates[0].avatar.emplace();
  EXPECT_FALSE(decode_state(encode(p), 3));
}

TEST(PassageCodec, WhetherSomebodyIsGoing) {
  for (const bool going : {false, true}) {
    sync::StatePacket p = packet_with({});
    p.updates[0].going = going;
    const auto again = decode_state(encode(p), 3);
    ASSERT_TRUE(again);
    EXPECT_EQ(*again, p);
    p.updates[0].passages.push_back(entry());
    EXPECT_FALSE(decode_state(encode(p), 3)) << "two sorts in one update";
  }
}

TEST(PassageCodec, NothingCrossesForTheZerothTime) {
  sync::Passage p = entry();
  p.crossings = 0;
  EXPECT_FALSE(decode_state(encode(packet_with({p})), 3));
}

/// A region in the middle of its session.
sync::Transfer transfer(const Scene& scene, int slots) {
  sync::Transfer t = sync::founding(scene, slots, true, 500, 1);
  t.tail.clear();
  t.state.residents.slots[0] = {};
  t.state.residents.slots[1].bound = 99;
  t.state.members[0].going = true;
  t.state.residents.gone.push_back({{scene.region->id, 0}, 1, 480});
  return t;
}

TEST(ResidentCodec, ComesOutAsItWentIn) {
  const crowd::Plane plane;
  const Scene scene = crowd::scene_of(plane, {1, 2});
  const sync::Transfer t = transfer(scene, plane.slots);
  const auto again = decode_transfer(encode_transfer(t), scene, plane.slots);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->state.residents, t.state.residents);
  EXPECT_EQ(sync::hash_of(again->state), sync::hash_of(t.state));
}

TEST(ResidentCodec, WhatNoRegionComesToIsRefused) {
  const crowd::Plane plane;
  const Scene scene = crowd::scene_of(plane, {1, 2});
  const auto refused = [&](const sync::Transfer& t) {
    return !decode_transfer(encode_transfer(t), scene, plane.slots).has_value();
  };
  sync::Transfer t = transfer(scene, plane.slots);
  t.state.residents.slots[2] = t.state.residents.slots[1];
  EXPECT_TRUE(refused(t)) << "one body in two slots";
  t = transfer(scene, plane.slots);
  t.state.residents.slots[0].crossings = 1;
  EXPECT_TRUE(refused(t)) << "something of nothing";
  t = transfer(scene, plane.slots);
  t.state.residents.gone[0].at = 501;
  EXPECT_TRUE(refused(t)) << "gone in the future";
  t = transfer(scene, plane.slots);
  t.state.residents.slots.pop_back();
  EXPECT_TRUE(refused(t)) << "a slot too few";
  t = transfer(scene, plane.slots);
  t.state.residents = {};
  EXPECT_TRUE(refused(t)) << "no slots at all";
}

}  // namespace
}  // namespace padr::wire
