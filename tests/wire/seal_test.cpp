#include "common/wire/seal.h"

#include <gtest/gtest.h>

#include "common/model/rng.h"
#include "tests/seed.h"

namespace padr::wire {
namespace {

Bytes sample() {
  const Bytes payload{std::byte{1}, std::byte{2}, std::byte{3}};
  return seal({Kind::kState, 4, 0x1234}, payload);
}

TEST(Seal, OpensWhatWasSealed) {
  const Bytes datagram = sample();
  EXPECT_EQ(datagram.size(), kHeaderBytes + 3 + kTagBytes);
  SealError error{};
  const auto opened = open(datagram, error);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->header.kind, Kind::kState);
  EXPECT_EQ(opened->header.sender, 4);
  EXPECT_EQ(opened->header.session, 0x1234);
  ASSERT_EQ(opened->payload.size(), 3U);
  EXPECT_EQ(opened->payload[2], std::byte{3});
}

TEST(Seal, AnySingleFlippedBitIsNoticed) {
  const Bytes good = sample();
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] ^= std::byte{1} << (bit % 8);
    SealError error{};
    EXPECT_FALSE(open(bad, error)) << "bit " << bit;
    EXPECT_NE(error, SealError::kNone);
  }
}

TEST(Seal, EveryCutAndRandomBytesAreRefused) {
  const Bytes good = sample();
  SealError error{};
  for (std::size_t n = 0; n < good.size(); ++n) EXPECT_FALSE(open(std::span(good).first(n), error)) << n;
  EXPECT_FALSE(open(Bytes(kMaxDatagram + 1), error));
  EXPECT_EQ(error, SealError::kTooLong);
  Rng rng(test::seed());
  for (int i = 0; i < 20000; ++i) {
    Bytes random(rng.below(80));
    for (std::byte& b : random) b = static_cast<std::byte>(rng.below(256));
    EXPECT_FALSE(open(random, error));
  }
}

TEST(Seal, AnotherVersionIsNamed) {
  // A datagram of another version, correctly sealed by its own rules.
  Bytes other = sample();
  other[2] = static_cast<std::byte>((kProtocolVersion + 1) << 4U);
  SealError error{};
  std::uint8_t version = 0;
  EXPECT_FALSE(open(other, error, &version));
  EXPECT_EQ(error, SealError::kTag) << "the tag covers the version";
}

}  // namespace
}  // namespace padr::wire
