// Known answers, the two modes of a sealed datagram, and that nothing of it can be changed.
#include "common/wire/secret.h"

#include <string>

#include "tests/channel/two_peers.h"

namespace padr::test {
namespace {

std::string hex(std::span<const std::byte> bytes) {
  std::string s;
  for (const std::byte b : bytes) {
    s += "0123456789abcdef"[std::to_integer<unsigned>(b) >> 4U];
    s += "0123456789abcdef"[std::to_integer<unsigned>(b) & 15U];
  }
  return s;
}

// Of the secret 00 01 02 .. 1f; the second implementation in tests/conformance, which is held against the RFC, agrees.
TEST(Secret, PublicKeysAreEd25519s) {
  wire::Key secret{};
  for (std::size_t i = 0; i < secret.size(); ++i) secret[i] = static_cast<std::uint8_t>(i);
  const PublicKey key = wire::public_key(secret);
  EXPECT_EQ(hex(std::as_bytes(std::span(key))), "03a107bff3ce10be1d70dd18e74bc09967e4d6309ba50d5f1ddc8664125531b8");
}

TEST(Secret, BothMakeTheSameKeysAndEachDirectionHasItsOwn) {
  const wire::Key session = key_of(1);
  const wire::Key a = key_of(2);
  const wire::Key b = key_of(3);
  const auto at_a = wire::pair_keys(session, a, wire::public_key(a), wire::public_key(b));
  const auto at_b = wire::pair_keys(session, b, wire::public_key(b), wire::public_key(a));
  ASSERT_TRUE(at_a && at_b);
  EXPECT_EQ(at_a->out, at_b->in);
  EXPECT_EQ(at_a->in, at_b->out);
  EXPECT_NE(at_a->in, at_a->out);
  const auto other = wire::pair_keys(key_of(4), a, wire::public_key(a), wire::public_key(b));
  EXPECT_NE(other->out, at_a->out) << "another session's key";
}

TEST(Secret, APublicKeyThatIsNoneMakesNoKeys) {
  const wire::Key a = key_of(2);
  EXPECT_FALSE(wire::pair_keys(key_of(1), a, wire::public_key(a), PublicKey{}));
  PublicKey one{};
  one[0] = 1;  // a point of low order
  EXPECT_FALSE(wire::pair_keys(key_of(1), a, wire::public_key(a), one));
}

class Sealed : public testing::TestWithParam<wire::SealMode> {};

TEST_P(Sealed, ComesBackAsItWas) {
  const wire::Key key = key_of(5);
  for (const std::size_t size : {0U, 1U, 100U, 1190U}) {
    const wire::Bytes unsealed = wire::seal({wire::Kind::kMembership, 7, 513}, wire::Bytes(size, std::byte{9}));
    const wire::Bytes sealed = wire::seal_with(key, GetParam(), 0xA1B2C3D4U, (std::uint64_t{5} << 32U) + 6, unsealed);
    EXPECT_EQ(sealed.size(), unsealed.size() + wire::kSealGrowth);
    const auto h = wire::read_sealed(sealed);
    ASSERT_TRUE(h);
    EXPECT_EQ(h->mode, GetParam());
    EXPECT_EQ(h->id, 0xA1B2C3D4U);
    EXPECT_EQ(h->number, 6U);
    EXPECT_EQ(wire::unseal_with(key, (std::uint64_t{5} << 32U) + 6, sealed), unsealed);
    EXPECT_FALSE(wire::unseal_with(key, 6, sealed)) << "the number's upper half counts, too";
    EXPECT_FALSE(wire::unseal_with(key_of(6), (std::uint64_t{5} << 32U) + 6, sealed));
    EXPECT_EQ(wire::unseal_unchecked(sealed).has_value(), GetParam() == wire::SealMode::kAuth);
  }
}

TEST_P(Sealed, NoBitOfItCanBeChanged) {
  const wire::Key key = key_of(5);
  const wire::Bytes sealed = wire::seal_with(key, GetParam(), 1, 2, words("some words"));
  for (std::size_t bit = 0; bit < 8 * sealed.size(); ++bit) {
    wire::Bytes other = sealed;
    other[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
    EXPECT_FALSE(wire::unseal_with(key, 2, other)) << "bit " << bit;
  }
  for (std::size_t size = 0; size < sealed.size(); ++size)
    EXPECT_FALSE(wire::unseal_with(key, 2, std::span(sealed).first(size)));
}

INSTANTIATE_TEST_SUITE_P(Modes, Sealed, testing::Values(wire::SealMode::kAuth, wire::SealMode::kEncrypt));

TEST(Secret, EncryptedWordsCannotBeRead) {
  const wire::Bytes sealed = wire::seal_with(key_of(5), wire::SealMode::kEncrypt, 1, 2, words("some words"));
  const std::string_view text(reinterpret_cast<const char*>(sealed.data()), sealed.size());
  EXPECT_EQ(text.find("some"), std::string_view::npos);
}

}  // namespace
}  // namespace padr::test
