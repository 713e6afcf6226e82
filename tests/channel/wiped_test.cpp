// That secrets are gone from memory when what held them has ended or has new ones. All memory that is given back is
// looked through, and so is all that is in use.
#include <gtest/gtest.h>
#include <malloc.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <new>

#include "tests/channel/talk.h"

namespace {

constexpr std::size_t kMost = 64;
constexpr std::size_t kBlocks = 1U << 16U;
constexpr std::uint8_t kMask = 0x5A;  // so that what is looked for is not itself found

std::array<std::array<std::uint8_t, 32>, kMost> watched{};
std::size_t watched_count = 0;
std::array<void*, kBlocks> in_use{};
std::size_t found_in_freed = 0;

/// Whether either half of a secret is there.
bool holds(const void* block, std::size_t which) {
  const auto* bytes = static_cast<const std::uint8_t*>(block);
  const std::size_t size = ::malloc_usable_size(const_cast<void*>(block));
  for (const std::size_t half : {0U, 16U})
    for (std::size_t at = 0; at + 16 <= size; ++at) {
      std::size_t same = 0;
      while (same < 16 && static_cast<std::uint8_t>(bytes[at + same] ^ kMask) == watched[which][half + same]) ++same;
      if (same == 16) return true;
    }
  return false;
}

std::size_t place_of(void* block) {
  std::size_t at = (reinterpret_cast<std::uintptr_t>(block) >> 4U) % kBlocks;
  for (std::size_t n = 0; n < kBlocks; ++n, at = (at + 1) % kBlocks)
    if (in_use[at] == block) return at;
  return kBlocks;
}

}  // namespace

void* operator new(std::size_t size) {
  void* block = std::malloc(size);
  if (block == nullptr) throw std::bad_alloc();
  std::size_t at = (reinterpret_cast<std::uintptr_t>(block) >> 4U) % kBlocks;
  for (std::size_t n = 0; watched_count > 0 && n < kBlocks; ++n, at = (at + 1) % kBlocks)
    if (in_use[at] == nullptr) {
      in_use[at] = block;
      break;
    }
  return block;
}

void operator delete(void* block) noexcept {
  if (block == nullptr) return;
  for (std::size_t n = 0; n < watched_count; ++n) found_in_freed += holds(block, n) ? 1U : 0U;
  if (watched_count > 0)
    if (const std::size_t at = place_of(block); at < kBlocks) in_use[at] = nullptr;
  std::free(block);
}

void operator delete(void* block, std::size_t) noexcept {
  operator delete(block);
}

namespace padr::test {
namespace {

void watch(std::span<const std::uint8_t> secret) {
  ASSERT_LT(watched_count, kMost);
  for (std::size_t i = 0; i < 32; ++i) watched[watched_count][i] = static_cast<std::uint8_t>(secret[i] ^ kMask);
  ++watched_count;
}

/// In memory that is in use.
bool is_kept(std::size_t which) {
  return std::any_of(in_use.begin(), in_use.end(), [&](void* b) { return b != nullptr && holds(b, which); });
}

struct Wiped : testing::Test {
  Wiped() { watched_count = found_in_freed = 0, in_use.fill(nullptr); }
  ~Wiped() override { watched_count = 0; }
};

/// What is left of an object of this type, made of `made`, in its place.
template <typename T>
std::vector<std::byte> left_of(const T& made) {
  alignas(T) std::array<std::byte, sizeof(T)> room{};
  std::destroy_at(std::construct_at(reinterpret_cast<T*>(room.data()), made));
  // As whoever looks into the memory of the process: the compiler may not say what was there.
  const volatile std::byte* seen = room.data();
  std::vector<std::byte> left(sizeof(T));
  std::copy_n(seen, sizeof(T), left.begin());
  return left;
}

TEST_F(Wiped, NothingIsLeftOfAKey) {
  const wire::Key key = key_of(1);
  EXPECT_EQ(left_of(key), std::vector<std::byte>(32));
  EXPECT_EQ(left_of(wire::PairKeys{key, key_of(2)}), std::vector<std::byte>(64));
  EXPECT_EQ(left_of(wire::signing_key(key)), std::vector<std::byte>(64));
  std::optional<wire::Key> held = key;
  const volatile std::uint8_t* seen = held->data();
  held.reset();
  for (std::size_t i = 0; i < key.size(); ++i) EXPECT_EQ(seen[i], 0);
}

// The test itself would notice: this keeps a key in plain bytes.
TEST_F(Wiped, WhatIsNotWipedIsFound) {
  const wire::Key key = key_of(3);
  watch(key);
  auto plain = std::make_unique<std::array<std::uint8_t, 40>>();
  std::copy(key.begin(), key.end(), plain->begin() + 3);
  EXPECT_TRUE(is_kept(0));
  plain.reset();
  EXPECT_EQ(found_in_freed, 1U);
  EXPECT_FALSE(is_kept(0));
}

struct Secrets : Wiped {
  static constexpr std::size_t kNone = kMost;
  /// A peer whose secrets are watched from when it draws or makes them.
  std::unique_ptr<node::SecureChannels> peer(std::uint64_t n) {
    node::ChannelConfig c = channel_config(n, wire::SealMode::kEncrypt);
    watch(c.session);
    seed = watched_count;
    watch(c.seed);
    secret = watched_count;
    watch(wire::derive_key(c.seed, "secret"));
    c.on_key = [this](const PublicKey&, const PublicKey&, const wire::Key& key) {
      keys.push_back(watched_count), watch(key);
    };
    c.random = [this, inner = c.random](std::span<std::byte> out) {
      inner(out);
      if (out.size() != 32) return;
      exchanges.push_back(watched_count);
      watch({reinterpret_cast<const std::uint8_t*>(out.data()), out.size()});
    };
    return std::make_unique<node::SecureChannels>(std::move(c));
  }
  std::size_t seed = kNone;
  std::size_t secret = kNone;
  std::vector<std::size_t> keys;       ///< in the order in which they were told
  std::vector<std::size_t> exchanges;  ///< secrets of new pairs
};

TEST_F(Secrets, AreGoneWithTheirChannelsAndWhenThereAreNewOnes) {
  {
    node::SecureChannels other(channel_config(2, wire::SealMode::kEncrypt));
    auto own = peer(1);
    Endpoint to_other = place(2);
    to_other.key = other.key();
    Endpoint to_own = place(1);
    to_own.key = own->key();
    for (Micros now = 0; now < 250 * kMicrosPerSecond; now += 100'000) {
      own->send(to_other, kNoPeer, words("one"), now);
      other.send(to_own, kNoPeer, words("other"), now);
      for (const auto& p : taken(*own)) other.receive(place(1), p.bytes, now);
      for (const auto& p : taken(other)) own->receive(place(2), p.bytes, now);
    }
    ASSERT_EQ(own->stats().rekeys, 3U);
    ASSERT_EQ(keys.size(), 8U);
    ASSERT_EQ(exchanges.size(), 3U);
    EXPECT_FALSE(is_kept(seed)) << "no longer needed";
    EXPECT_TRUE(is_kept(secret)) << "which finds what there is";
    for (const std::size_t k : {2U, 3U, 4U, 5U}) EXPECT_FALSE(is_kept(keys[k])) << "key " << k;
    for (const std::size_t k : {6U, 7U}) EXPECT_TRUE(is_kept(keys[k])) << "key " << k << " is in use";
    for (const std::size_t e : exchanges) EXPECT_FALSE(is_kept(e));
  }
  EXPECT_EQ(found_in_freed, 0U);
}

}  // namespace
}  // namespace padr::test
