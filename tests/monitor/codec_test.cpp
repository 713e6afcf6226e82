#include "common/monitor/codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>

#include "tests/monitor/samples.h"
#include "tests/seed.h"

namespace padr {
namespace {

using monitor::Bytes;

const monitor::Origin kFrom{42, 7, 3, 1};

TEST(MonitorCodec, MessagesComeBackAsTheyWere) {
  const std::uint64_t seed = test::seed();
  Rng rng(seed);
  for (std::uint32_t i = 0; i < 3000; ++i) {
    const monitor::Origin from = test::any_origin(rng);
    const monitor::Message message = test::any_message(rng, i % 6);
    const auto datagrams = monitor::encode(from, message);
    ASSERT_GE(datagrams.size(), 1U);
    for (const Bytes& d : datagrams) {
      EXPECT_LE(d.size(), monitor::kMostBytes);
      const auto told = monitor::decode_told(d);
      ASSERT_TRUE(told) << "seed " << seed << ", message " << i;
      EXPECT_EQ(told->from, from);
      EXPECT_TRUE(datagrams.size() > 1 || told->message == message) << "seed " << seed << ", message " << i;
      EXPECT_FALSE(monitor::decode_order(d));
    }
  }
}

TEST(MonitorCodec, OrdersComeBackAsTheyWere) {
  Rng rng(test::seed());
  for (int i = 0; i < 2000; ++i) {
    const monitor::Order order = test::any_order(rng);
    const Bytes d = monitor::encode(order);
    EXPECT_LE(d.size(), monitor::kMostBytes);
    const auto again = monitor::decode_order(d);
    ASSERT_TRUE(again);
    EXPECT_TRUE(*again == order);
    EXPECT_FALSE(monitor::decode_told(d));
  }
}

TEST(MonitorCodec, ALargeFrameIsToldInRangesThatHaveEveryEntityOnce) {
  Rng rng(test::seed());
  for (const int entities : {0, 1, 60, 222, 5000}) {
    for (int views = 1; views <= 3; ++views) {
      const monitor::Frame whole = test::any_frame(rng, static_cast<EntityId>(entities), views);
      monitor::Frame again;
      for (const Bytes& d : monitor::encode(kFrom, whole)) {
        EXPECT_LE(d.size(), monitor::kMostBytes);
        const auto told = monitor::decode_told(d);
        ASSERT_TRUE(told);
        monitor::Frame part = std::get<monitor::Frame>(told->message);
        EXPECT_EQ(part.first, again.flags.size());
        const auto append = [](auto& to, const auto& more) { to.insert(to.end(), more.begin(), more.end()); };
        append(again.flags, part.flags);
        append(again.shown, part.shown);
        append(again.live, part.live);
        append(again.predicted, part.predicted);
        part.first = 0;
        std::swap(part.flags, again.flags);
        std::swap(part.shown, again.shown);
        std::swap(part.live, again.live);
        std::swap(part.predicted, again.predicted);
        again = part;
      }
      EXPECT_TRUE(again == whole) << entities << " entities, " << views << " views";
    }
  }
}

TEST(MonitorCodec, AStatusWithManyLinksIsToldInSeveralThatHaveAll) {
  Rng rng(test::seed());
  monitor::Status whole = std::get<monitor::Status>(test::any_message(rng, 4));
  whole.links.clear();
  for (PeerId p = 0; p < 63; ++p) {
    monitor::LinkStatus l;
    l.to = p;
    l.netem = std::string(p * 6, 'n');
    whole.links.push_back(l);
  }
  monitor::Status again = whole;
  again.links.clear();
  const auto datagrams = monitor::encode(kFrom, whole);
  EXPECT_GT(datagrams.size(), 5U);
  for (const Bytes& d : datagrams) {
    EXPECT_LE(d.size(), monitor::kMostBytes);
    const auto told = monitor::decode_told(d);
    ASSERT_TRUE(told);
    const auto& part = std::get<monitor::Status>(told->message);
    EXPECT_EQ(part.bytes_sent, whole.bytes_sent);
    again.links.insert(again.links.end(), part.links.begin(), part.links.end());
  }
  EXPECT_TRUE(again == whole);
}

TEST(MonitorCodec, DropsOfALinkComeByReasonAndNotMoreReasonsThanThereAre) {
  monitor::LinkStatus l;
  l.to = 3;
  l.dropped.fill(1);
  l.dropped.back() = 200;  // two bytes
  l.cut_offs = 2;
  monitor::Status s;
  s.links = {l};
  Bytes datagram = monitor::encode(kFrom, s).at(0);
  const auto told = monitor::decode_told(datagram);
  ASSERT_TRUE(told);
  EXPECT_EQ(std::get<monitor::Status>(told->message).links, s.links);
  // Of as many bytes, but two numbers where there was one.
  const std::array last{std::byte{1}, std::byte{200}, std::byte{1}};
  const auto at = std::search(datagram.begin(), datagram.end(), last.begin(), last.end());
  ASSERT_NE(at, datagram.end());
  *(at + 1) = std::byte{1};
  EXPECT_FALSE(monitor::decode_told(datagram));
}

TEST(MonitorCodec, OfTooManyEventsTheNewestAreTold) {
  monitor::Events all;
  for (std::uint32_t n = 1; n <= 40; ++n) all.events.push_back({n, 0, monitor::EventKind::kKnob, 0, 0, 0, "text"});
  const auto told = monitor::decode_told(monitor::encode(kFrom, all).at(0));
  ASSERT_TRUE(told);
  const auto& events = std::get<monitor::Events>(told->message).events;
  EXPECT_EQ(events.size(), monitor::kMostEvents);
  EXPECT_EQ(events.back().number, 40U);
  for (monitor::Event& e : all.events) e.text = std::string(2000, 'x');
  const auto long_ones = monitor::encode(kFrom, all);
  ASSERT_EQ(long_ones.size(), 1U);
  EXPECT_LE(long_ones[0].size(), monitor::kMostBytes);
  const auto cut = monitor::decode_told(long_ones[0]);
  ASSERT_TRUE(cut);
  EXPECT_EQ(std::get<monitor::Events>(cut->message).events.back().number, 40U);
  EXPECT_EQ(std::get<monitor::Events>(cut->message).events.back().text.size(), monitor::kMostText);
}

TEST(MonitorCodec, LongTextsOfUsersAreCutAndFit) {
  monitor::Hello h;
  for (std::string* s : {&h.version, &h.scenario, &h.technique, &h.netem, &h.input}) *s = std::string(5000, 'y');
  const auto d = monitor::encode(kFrom, h);
  ASSERT_EQ(d.size(), 1U);
  EXPECT_LE(d[0].size(), monitor::kMostBytes);
  EXPECT_TRUE(monitor::decode_told(d[0]));
}

TEST(MonitorCodec, PositionsAreToldToTheMillimetreAndAnglesWithinATurn) {
  monitor::Frame f;
  f.total = 2;
  f.flags.resize(2);
  f.shown = {{{1.23449F, -1.2346F}, 7}, {{std::numeric_limits<float>::infinity(), 3.0e9F}, 1.0e9F}};
  const auto told = monitor::decode_told(monitor::encode(kFrom, f).at(0));
  ASSERT_TRUE(told);
  const auto& shown = std::get<monitor::Frame>(told->message).shown;
  EXPECT_FLOAT_EQ(shown[0].position.x, 1.234F);
  EXPECT_FLOAT_EQ(shown[0].position.y, -1.235F);
  EXPECT_NEAR(shown[0].angle, 7 - 6.2832F, 1e-3F);
  EXPECT_EQ(shown[1].position, (Vec2{0, 0})) << "what is no place must not break anything";
  EXPECT_LE(std::abs(shown[1].angle), 3.1421F);
}

TEST(MonitorCodec, ValuesOutOfRangeAreRefusedOnBothSidesOfTheirLimits) {
  const auto taken = [](const monitor::What& what) {
    return monitor::decode_order(monitor::encode({1, 2, 3, 4, what}));
  };
  using Kind = monitor::Drive::Kind;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(taken(monitor::Drive{Kind::kDirection, {1, -1}}));
  EXPECT_FALSE(taken(monitor::Drive{Kind::kDirection, {1.001F, 0}}));
  EXPECT_FALSE(taken(monitor::Drive{Kind::kDirection, {0, nan}}));
  EXPECT_TRUE(taken(monitor::Drive{Kind::kPoint, {1.0e6F, 0}}));
  EXPECT_FALSE(taken(monitor::Drive{Kind::kPoint, {1.1e6F, 0}}));
  EXPECT_TRUE(taken(monitor::Cut{5, 600}));
  EXPECT_TRUE(taken(monitor::Cut{5, 600, monitor::Ways::kIn}));
  EXPECT_FALSE(taken(monitor::Cut{5, 600, static_cast<monitor::Ways>(3)}));
  EXPECT_FALSE(taken(monitor::Cut{5, 600.1F}));
  EXPECT_FALSE(taken(monitor::Cut{5, -0.1F}));
  EXPECT_TRUE(taken(monitor::Cut{63, 1}));
  EXPECT_FALSE(taken(monitor::Cut{64, 1}));
  EXPECT_TRUE(taken(monitor::Pause{0}));
  EXPECT_FALSE(taken(monitor::Pause{nan}));
  EXPECT_TRUE(taken(monitor::Push{0, {monitor::kMostPush, 0}}));
  EXPECT_FALSE(taken(monitor::Push{0, {monitor::kMostPush + 0.1F, 0}}));
  EXPECT_FALSE(taken(monitor::Push{kNoEntity, {1, 0}}));
  EXPECT_FALSE(monitor::decode_order(monitor::encode({1, 2, 0, 4, monitor::Pause{1}}))) << "no issuer";
  EXPECT_FALSE(monitor::decode_order(monitor::encode({1, 2, 3, 0, monitor::Pause{1}}))) << "no number";
}

TEST(MonitorCodec, DamagedDatagramsAreRefusedOrDecodeToSomethingThatEncodes) {
  const std::uint64_t seed = test::seed();
  Rng rng(seed);
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    const bool order = rng.chance(0.3);
    Bytes d = order ? monitor::encode(test::any_order(rng))
                    : monitor::encode(test::any_origin(rng), test::any_message(rng, rng.below(6))).at(0);
    for (std::uint32_t n = 1 + rng.below(4); n > 0; --n)
      d[rng.below(static_cast<std::uint32_t>(d.size()))] = static_cast<std::byte>(rng.below(256));
    if (rng.chance(0.2)) d.resize(rng.below(static_cast<std::uint32_t>(d.size())));
    const auto told = monitor::decode_told(d);
    EXPECT_FALSE(told && monitor::encode(told->from, told->message).empty());
    const auto again = monitor::decode_order(d);
    EXPECT_FALSE(again && monitor::encode(*again).empty());
  }
  EXPECT_FALSE(monitor::decode_told({}));
  Bytes longer = monitor::encode(kFrom, monitor::Events{}).at(0);
  ASSERT_TRUE(monitor::decode_told(longer));
  longer.resize(monitor::kMostBytes + 1);
  EXPECT_FALSE(monitor::decode_told(longer));
}

}  // namespace
}  // namespace padr
