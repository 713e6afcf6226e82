#include "common/wire/membership_codec.h"

#include <gtest/gtest.h>

#include "tests/seed.h"
#include "tests/wire/samples.h"

namespace padr::wire {
namespace {

using test::any_membership;
using test::kMembershipKinds;

std::vector<Seat> seats(int n) {
  std::vector<Seat> s;
  for (int p = 0; p < n; ++p) s.push_back({static_cast<PeerId>(p), ~0U, ~0U});
  return s;
}

std::vector<Seat> heard(std::vector<Seat> all, std::uint32_t when) {
  for (Seat& s : all) s.heard = when;
  return all;
}

sync::Bundle bye(std::uint32_t index, Tick tick) {
  sync::Bundle b;
  b.peer = 3;
  b.index = index;
  b.tick = tick;
  b.leave = true;
  return b;
}

TEST(MembershipCodec, EveryMessageComesBackAsItWas) {
  Rng rng(test::seed());
  for (std::size_t i = 0; i < 4000; ++i) {
    const MembershipMessage m = any_membership(rng, i);
    ASSERT_EQ(m.index(), i % kMembershipKinds);
    const Bytes bytes = encode_membership(m);
    ASSERT_LE(bytes.size(), kMaxPayload);
    const auto back = decode_membership(bytes);
    ASSERT_TRUE(back) << i;
    ASSERT_EQ(*back, m) << i;
  }
}

TEST(MembershipCodec, BothSidesOfEveryLimit) {
  const Bytes one(1);
  const Bytes most(kPieceBytes);
  constexpr std::uint64_t kNonce = ~0ULL;
  Endpoint keyed = ipv4({1, 2, 3, 4}, 0xFFFF);
  keyed.key.fill(1);
  const std::vector<MembershipMessage> good{
      Pull{1, 0, 0, 1},
      Pull{kNonce, kMaxPieces - 1, ~0ULL, ~0ULL},
      Piece{1, 0, 1, one},
      Piece{kNonce, kMaxPieces - 1, kMaxPieces, most},
      Enter{1},
      Enter{kNonce},
      Poll{seats(1)},
      Poll{seats(62), true, kMostPollNumber},
      Answer{{{63, 0, 0}}},
      Answer{heard(seats(62), 0x3FFF), true, 0x7FFFFFFF, kMostPollNumber},
      Fetch{0, 0, 0},
      Fetch{63, ~0U, ~0U},
      Fetched{3, ~0U, {bye(0, 0)}},
      Fetched{3, 0, {bye(5, 7), bye(6, 8)}},
      Fetched{3, 0, {bye(0xFFFFFFFEU, 0x7FFFFFFE)}},
      Probe{0, seats(1), false, 0},
      Probe{~0U, seats(64), true, ~0U},
      Reach{0, {}},
      Reach{0x7FFFFFFF, {{0, 0}, {63, kMostDelay, true}}},
      Reach{0, {}, std::vector<Endpoint>(4, ipv4({1, 2, 3, 4}, 0xFFFF))},
      Newcomer{ipv4({1, 2, 3, 4}, 1)},
      Newcomer{keyed},
  };
  for (std::size_t i = 0; i < good.size(); ++i) {
    const Bytes bytes = encode_membership(good[i]);
    EXPECT_LE(bytes.size(), kMaxPayload) << i;
    const auto back = decode_membership(bytes);
    ASSERT_TRUE(back) << i;
    EXPECT_EQ(*back, good[i]) << i;
  }
  const std::vector<MembershipMessage> wrong{
      Pull{0, 0, 1, 1},
      Pull{1, 0, 1, 0},
      Pull{1, kMaxPieces, 1, 1},
      Piece{0, 0, 1, one},
      Piece{1, 0, 0, one},
      Piece{1, 1, 1, one},
      Piece{1, 0, kMaxPieces + 1, one},
      Piece{1, 0, 1, {}},
      Piece{1, 0, 1, Bytes(kPieceBytes + 1)},
      Enter{0},
      Poll{},
      Poll{seats(63)},
      Poll{{{1, 0, 0}, {1, 1, 0}}},
      Poll{{{2, 0, 0}, {1, 0, 0}}},
      Poll{seats(1), true, kMostPollNumber + 1},
      Answer{},
      Answer{seats(1), true, 0, kMostPollNumber + 1},
      Answer{seats(63)},
      Answer{heard(seats(1), 0x4000)},
      Answer{seats(1), false, -1},
      Answer{{{64, 0, 0}}},
      Answer{{{1, 0, 0}, {1, 1, 0}}},
      Fetch{64, 0, 0},
      Fetched{64, 0, {bye(0, 0)}},
      Fetched{3, 0, {bye(0, 0x7FFFFFFF)}},
      Probe{0, {}, false, 0},
      Probe{0, seats(65), false, 0},
      Probe{0, {{2, 0, 0}, {2, 0, 0}}, false, 0},
      Probe{0, {{2, 0, 0}, {1, 0, 0}}, false, 0},
      Reach{-1, {}},
      Reach{0, std::vector<Way>(65)},
      Reach{0, {{64, 0}}},
      Reach{0, {{0, kMostDelay + 1}}},
      Reach{0, {{2, 0}, {2, 0}}},
      Reach{0, {{2, 0}, {1, 0}}},
      Reach{0, {}, std::vector<Endpoint>(5, ipv4({1, 2, 3, 4}, 0xFFFF))},
      Reach{0, {}, {ipv4({1, 2, 3, 4}, 0)}},
      Reach{0, {}, {Endpoint{}}},
      Newcomer{},
      Newcomer{ipv4({1, 2, 3, 4}, 0)},
  };
  for (std::size_t i = 0; i < wrong.size(); ++i) EXPECT_FALSE(decode_membership(encode_membership(wrong[i]))) << i;
  EXPECT_FALSE(decode_membership({}));
}

TEST(MembershipCodec, FetchedUpdatesAscendByNumberAndTick) {
  // The encoder counts back from the last update, so what is out of order is put together here: field 7, its field 3
  // with mark_tick 9, mark_count 9, and two updates (goodbyes) with their index_back and tick_back.
  const auto fetched = [](int index0, int tick0, int index1, int tick1) {
    Bytes b;
    for (const int v : {0x3A,   22,   0x08,  3,    0x1A, 18,   0x10, 9,    0x18,   9,    0x4A,  6,    0x08,
                        index0, 0x10, tick0, 0x50, 1,    0x4A, 6,    0x08, index1, 0x10, tick1, 0x50, 1})
      b.push_back(static_cast<std::byte>(v));
    b[1] = static_cast<std::byte>(b.size() - 2);
    b[5] = static_cast<std::byte>(b.size() - 6);
    return decode_membership(b);
  };
  ASSERT_TRUE(fetched(3, 3, 2, 2));
  EXPECT_EQ(*fetched(3, 3, 2, 2), (MembershipMessage{Fetched{3, 0, {bye(5, 6), bye(6, 7)}}}));
  EXPECT_FALSE(fetched(3, 3, 3, 2)) << "a number twice";
  EXPECT_FALSE(fetched(3, 3, 2, 3)) << "a tick twice";
  EXPECT_FALSE(fetched(2, 3, 3, 2)) << "numbers that descend";
  EXPECT_FALSE(fetched(9, 3, 2, 2)) << "a number below 0";
  EXPECT_FALSE(fetched(3, 10, 2, 2)) << "a tick before the start";
}

// Once, the peer that was asked for them aborted.
TEST(MembershipCodec, FetchedEndsBeforeAnUpdateThatIsOutOfOrder) {
  for (const sync::Bundle& wrong : {bye(8, 9), bye(9, 2), bye(6, 10), bye(2, 10)}) {
    const Bytes bytes = encode_membership(Fetched{3, 0, {bye(5, 7), bye(6, 9), wrong, bye(10, 11)}});
    EXPECT_EQ(decode_membership(bytes), (MembershipMessage{Fetched{3, 0, {bye(5, 7), bye(6, 9)}}}));
  }
}

TEST(MembershipCodec, FetchedTakesAsManyUpdatesAsFit) {
  Fetched f{63, 0, {}};
  sync::Bundle b = test::largest_bundle(sync::kMaxPassing);
  b.index = 0;
  b.tick -= 10;
  f.updates.push_back(b);
  for (std::uint32_t i = 1; i < 5; ++i) {
    f.updates.push_back(f.updates.back());
    f.updates.back().index = i;
    ++f.updates.back().tick;
  }
  const Bytes bytes = encode_membership(f);
  EXPECT_LE(bytes.size(), kMaxPayload) << "the largest of all updates goes alone";
  auto back = decode_membership(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(std::get<Fetched>(*back).updates, std::vector<sync::Bundle>{f.updates.front()});

  f.updates.clear();
  for (std::uint32_t i = 0; i < 500; ++i) {
    f.updates.push_back(bye(i, static_cast<Tick>(1000 + i)));
    f.updates.back().peer = 63;
  }
  back = decode_membership(encode_membership(f));
  ASSERT_TRUE(back);
  const std::size_t n = std::get<Fetched>(*back).updates.size();
  EXPECT_GT(n, 50U);
  EXPECT_LT(n, 500U);
  f.updates.resize(n);
  EXPECT_EQ(std::get<Fetched>(*back), f) << "the first ones, in order";
}

/// The ranges that the structs state, in words of their own.
struct Range {
  static bool nonce(std::uint64_t v) { return v != 0; }
  static bool of(const std::vector<Seat>& s) {
    for (std::size_t i = 0; i < s.size(); ++i)
      if (s[i].heard > 0x3FFF || s[i].slot >= kMaxPeers || (i > 0 && s[i].slot <= s[i - 1].slot)) return false;
    return !s.empty();
  }
  bool operator()(const Pull& m) const { return nonce(m.nonce) && m.from < kMaxPieces && m.cookie != 0; }
  bool operator()(const Piece& m) const {
    return nonce(m.nonce) && m.index < m.count && m.count <= kMaxPieces && !m.bytes.empty() &&
           m.bytes.size() <= kPieceBytes;
  }
  bool operator()(const Enter& m) const { return nonce(m.nonce); }
  bool operator()(const Poll& m) const { return of(m.lost) && m.lost.size() <= 62; }
  bool operator()(const Answer& m) const { return of(m.lost) && m.lost.size() <= 62 && m.tick >= 0; }
  bool operator()(const Fetch& m) const { return m.slot < kMaxPeers; }
  bool operator()(const Fetched& m) const {
    for (const sync::Bundle& b : m.updates)
      if (b.peer != m.slot || b.tick < 0 || b.bodies.size() > sync::kMaxBodiesPerBundle || b.passed_on.size() > 1)
        return false;
    return m.slot < kMaxPeers && !m.updates.empty();
  }
  bool operator()(const Probe& m) const { return of(m.members); }
  bool operator()(const Reach& m) const {
    for (std::size_t i = 0; i < m.heard.size(); ++i)
      if (m.heard[i].slot >= kMaxPeers || m.heard[i].delay > kMostDelay ||
          (i > 0 && m.heard[i].slot <= m.heard[i - 1].slot))
        return false;
    return m.tick >= 0 && m.at.size() <= 4 &&
           std::all_of(m.at.begin(), m.at.end(), [](const Endpoint& e) { return e.is_set() && !e.has_key(); });
  }
  bool operator()(const Newcomer& m) const { return m.at.is_set(); }
};

TEST(MembershipCodec, DamageNeverCrashesAndNothingOutOfRangeGetsIn) {
  Rng rng(test::seed());
  int accepted = 0;
  for (std::size_t i = 0; i < 30000; ++i) {
    Bytes bytes = encode_membership(any_membership(rng, i));
    if (i % 3 == 0) bytes.resize(rng.below(static_cast<std::uint32_t>(bytes.size()) + 1));
    if (i % 16 == 0) bytes.assign(rng.below(60), std::byte{0});
    for (std::uint32_t n = rng.below(4); n > 0 && !bytes.empty(); --n)
      bytes[rng.below(static_cast<std::uint32_t>(bytes.size()))] = static_cast<std::byte>(rng.below(256));
    const auto m = decode_membership(bytes);
    if (!m) continue;
    ++accepted;
    ASSERT_TRUE(std::visit(Range{}, *m)) << i;
  }
  EXPECT_GT(accepted, 1000) << "or nothing has been tested";
}

}  // namespace
}  // namespace padr::wire
