// Values of states: whatever they are, what is read is what was told, to the bit, and there is one way to tell it.
#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <utility>

#include "common/model/precision.h"
#include "common/model/rng.h"
#include "common/wire/codec.h"
#include "tests/seed.h"

namespace padr::wire {
namespace {

using sync::BodyUpdate;
using sync::Bundle;
using sync::StatePacket;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

StatePacket with(const std::vector<BodyState>& states) {
  StatePacket p;
  p.seq = 1;
  p.mark_tick = 5000;
  p.mark_count = 100;
  Bundle& b = p.updates.emplace_back();
  b.peer = 1;
  b.index = 99;
  b.tick = 5000;
  for (const BodyState& s : states) {
    BodyUpdate& u = b.bodies.emplace_back();
    u.body = static_cast<EntityId>(b.bodies.size());
    u.has_state = true;
    u.epoch = 3;
    u.claimed = 4990;
    u.state = s;
  }
  return p;
}

std::array<std::uint32_t, 6> bits(const BodyState& s) {
  return {std::bit_cast<std::uint32_t>(s.position.x), std::bit_cast<std::uint32_t>(s.position.y),
          std::bit_cast<std::uint32_t>(s.angle),      std::bit_cast<std::uint32_t>(s.velocity.x),
          std::bit_cast<std::uint32_t>(s.velocity.y), std::bit_cast<std::uint32_t>(s.spin)};
}

/// Of all floats, those that can be told in steps too, and those that nearly can.
float any_value(Rng& rng, float step) {
  const std::uint32_t sort = rng.below(8);
  if (sort == 0) return std::bit_cast<float>(rng.next_u32());
  if (sort == 1) return static_cast<float>(rng.uniform(-1e6, 1e6));
  const auto n = static_cast<std::int32_t>(rng.next_u32()) >> (6 + rng.below(25));
  const float v = static_cast<float>(n) * step;
  if (sort == 2) return std::nextafter(v, rng.chance(0.5) ? kInfinity : -kInfinity);
  return v;
}

BodyState any_state(Rng& rng) {
  BodyState s;
  s.position = {any_value(rng, kPlaceStep), any_value(rng, kPlaceStep)};
  s.angle = any_value(rng, kPlaceStep);
  s.velocity = {any_value(rng, kMotionStep), any_value(rng, kMotionStep)};
  s.spin = any_value(rng, kMotionStep);
  return s;
}

TEST(Values, ComeBackToTheBitWhateverTheyAre) {
  Rng rng(test::seed());
  int in_steps = 0;
  for (int i = 0; i < 20000; ++i) {
    const BodyState s = any_state(rng);
    const StatePacket p = with({s});
    const auto back = decode_state(encode(p), 1);
    ASSERT_TRUE(back) << i;
    ASSERT_EQ(bits(back->updates.at(0).bodies.at(0).state), bits(s)) << i;
    ASSERT_LE(encode(p).size(), kStateOverhead + encoded_size(p.updates[0]));
    if (rounded(s) == s) ++in_steps;
  }
  EXPECT_GT(in_steps, 1000);
}

BodyState ordinary() {
  return {{8.17166328F, 8.14824486F}, 2.0466987F, {-3.83107924F, 1.68302679F}, 2.80191636F, true};
}

std::size_t bytes_per_body(const BodyState& s, std::size_t bodies) {
  return (encode(with(std::vector(bodies, s))).size() - encode(with({})).size()) / bodies;
}

TEST(Values, RoundedAreToldInFewerBytesThanTheirFloats) {
  EXPECT_LE(bytes_per_body(rounded(ordinary()), 16), 24U);
  EXPECT_LE(bytes_per_body(rounded(ordinary()), 1), 27U);
  EXPECT_GT(bytes_per_body(ordinary(), 16), 24U);
}

// Every single one can keep all of its update from being told in steps.
TEST(Values, AreToldInStepsIfAllAreWhole) {
  const std::size_t few = bytes_per_body(rounded(ordinary()), 4);
  EXPECT_LT(few, 24U);
  const auto spoilt = [&](float BodyState::*value, float by) {
    BodyState s = rounded(ordinary());
    s.*value = by;
    return bytes_per_body(s, 4);
  };
  for (const float v : {kNone, kInfinity, -kInfinity, -0.0F, 1e30F, 1e-30F, 0.1F, 1024.0F, -1024.0F})
    EXPECT_GT(spoilt(&BodyState::angle, v), 24U) << v;
  for (const float v : {0.0F, 1023.99993896484375F, -1023.99993896484375F, kPlaceStep})
    EXPECT_LT(spoilt(&BodyState::angle, v), 24U) << v;
  EXPECT_GT(spoilt(&BodyState::spin, kPlaceStep), 24U);
  EXPECT_GT(spoilt(&BodyState::spin, 4096), 24U);
  EXPECT_LT(spoilt(&BodyState::spin, -4095.999755859375F), 24U);
}

TEST(Rounding, IsWithinAStepAndWhole) {
  Rng rng(test::seed());
  for (int i = 0; i < 20000; ++i) {
    const auto v = static_cast<float>(rng.uniform(-900, 900));
    const float near = to_nearest(v, kPlaceStep);
    const float less = towards_zero(v, kMotionStep);
    ASSERT_TRUE(in_steps(near, kPlaceStep) && in_steps(less, kMotionStep)) << v;
    ASSERT_LE(std::abs(near - v), kPlaceStep / 2) << v;
    ASSERT_LT(std::abs(less - v), kMotionStep) << v;
    ASSERT_LE(std::abs(less), std::abs(v));
    ASSERT_EQ(to_nearest(near, kPlaceStep), near);
    ASSERT_EQ(towards_zero(less, kMotionStep), less);
    ASSERT_EQ(from_steps(to_steps(near, kPlaceStep), kPlaceStep), near);
  }
}

TEST(Rounding, LeavesNoMinusZeroAndWhatCannotBeRounded) {
  for (const float v : {-0.0F, -1e-6F, 1e-6F}) {
    EXPECT_FALSE(std::signbit(to_nearest(v, kPlaceStep))) << v;
    EXPECT_FALSE(std::signbit(towards_zero(v, kMotionStep))) << v;
  }
  for (const float v : {kInfinity, -kInfinity, 1e30F, 123456.789F, -4096.5F}) {
    EXPECT_EQ(to_nearest(v, kPlaceStep), v);
    EXPECT_EQ(towards_zero(v, kMotionStep), v);
  }
  EXPECT_TRUE(std::isnan(to_nearest(kNone, kPlaceStep)));
  EXPECT_TRUE(std::isnan(towards_zero(kNone, kMotionStep)));
}

// What is at rest stays there, and what slows down comes to rest, though it be told at every tick.
TEST(Rounding, LetsThingsRest) {
  EXPECT_EQ(rounded({{1, 2}, 3, {}, 0, false}), (BodyState{{1, 2}, 3, {}, 0, false}));
  Vec2 v{3, -2};
  for (int i = 0; i < 60 * kTicksPerSecond; ++i) v = rounded_motion(v * (1 - 0.3F * kTickSeconds));
  EXPECT_EQ(v, Vec2{});
}

/// A datagram's payload with one update: of an avatar of the first-order model, and these columns.
Bytes told(const std::vector<int>& columns) {
  std::vector<int> bytes{0x0A, 3, 1, 100, 1, 0x4A, static_cast<int>(2 + columns.size()), 0x18, 0x68};
  bytes.insert(bytes.end(), columns.begin(), columns.end());
  Bytes out;
  for (const int b : bytes) out.push_back(static_cast<std::byte>(b));
  return out;
}

TEST(Values, ThereIsOneWayToTellThem) {
  const std::vector<std::pair<std::vector<int>, const char*>> good{
      {{0x32, 4, 1, 2, 3, 4}, "in steps"},
      {{0x32, 2, 1, 2, 0x32, 2, 3, 4}, "in steps, in two pieces"},
      {{0x32, 4, 1, 2, 3, 4, 0x2A, 0}, "in steps, and no floats"},
      {{0x32, 7, 1, 2, 3, 0xFE, 0xFF, 0xFF, 0x0F}, "the most steps"},
      {{0x32, 7, 1, 2, 3, 0xFD, 0xFF, 0xFF, 0x0F}, "the most steps back"},
      {{0x2A, 16, 0, 0, 0, 0x80, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "floats with a -0"},
  };
  for (const auto& [columns, what] : good) EXPECT_TRUE(decode_state(told(columns), 1)) << what;
  const std::vector<std::pair<std::vector<int>, const char*>> bad{
      {{0x32, 3, 1, 2, 3}, "too few"},
      {{0x32, 5, 1, 2, 3, 4, 5}, "too many"},
      {{0x32, 7, 1, 2, 3, 0x80, 0x80, 0x80, 0x10}, "a step more than the most"},
      {{0x32, 7, 1, 2, 3, 0xFF, 0xFF, 0xFF, 0x0F}, "a step more than the most, back"},
      {{0x2A, 16, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "floats that are whole steps"},
      {{0x32, 4, 1, 2, 3, 4, 0x2A, 4, 0, 0, 0, 0x80}, "in steps, and a float"},
      {{0x32, 2, 1, 2, 0x2A, 8, 0, 0, 0, 0x80, 0, 0, 0, 0x80}, "half in steps"},
      {{0x2A, 16, 0, 0, 0, 0x80, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x32, 1, 0}, "floats, and a step"},
  };
  for (const auto& [columns, what] : bad) EXPECT_FALSE(decode_state(told(columns), 1)) << what;
}

// Of an update without avatar and bodies.
TEST(Values, ThatBelongToNothingAreNotRead) {
  for (const auto& columns : std::vector<std::vector<int>>{
           {0x32, 4, 1, 2, 3, 4}, {0x2A, 16, 0, 0, 0, 0x80, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}}) {
    Bytes bytes = told(columns);
    EXPECT_TRUE(decode_state(bytes, 1));
    constexpr std::size_t kAvatar = 8;
    bytes[kAvatar] = std::byte{0};
    EXPECT_FALSE(decode_state(bytes, 1)) << columns[0];
  }
}

}  // namespace
}  // namespace padr::wire
