// A whole peer, of which padr-peer is one with a clock and a socket: what it sends is handed over without allocating,
// sealed or not.
#include "common/participant/participant.h"

#include <gtest/gtest.h>

#include <array>
#include <deque>
#include <memory>
#include <utility>

#include "tests/bench/allocations.h"
#include "tests/bench/party.h"

namespace padr::bench {
namespace {

constexpr Micros kTurn = kMicrosPerSecond / kTicksPerSecond;
constexpr std::size_t kDelay = 3;  // turns

Endpoint place(std::size_t n) {
  return ipv4({10, 0, 0, static_cast<std::uint8_t>(n + 1)}, 7000);
}

/// Two, the first of whom is counted.
class Pair {
 public:
  explicit Pair(wire::SealMode seal) {
    for (std::size_t n = 0; n < 2; ++n) {
      node::ParticipantConfig c;
      if (n > 0) c.session.join = place(0);
      c.session.wanted = 2;
      c.session.slots = 2;
      c.session.seed = n + 1;
      if (seal != wire::SealMode::kNone) {
        c.channels.emplace();
        c.channels->seed[0] = static_cast<std::uint8_t>(n + 1);
        c.channels->random = [own = Rng(n)](std::span<std::byte> out) mutable {
          for (std::byte& b : out) b = static_cast<std::byte>(own.below(256));
        };
        c.channels->mode = seal;
      }
      peers_[n] = std::make_unique<node::Participant>(scene_, std::move(c), now_);
    }
  }
  bool plays() const { return peers_[0]->playing() && peers_[1]->playing(); }
  std::uint64_t sent() const { return sent_; }
  std::uint64_t counted() const { return counted_; }

  void turn() {
    now_ += kTurn;
    for (std::size_t n = 0; n < 2; ++n) {
      const std::uint64_t before = allocations();
      work(n);
      if (n == 0) counted_ += allocations() - before;
      std::deque<std::vector<wire::Bytes>>& way = on_way_[1 - n];
      way.emplace_back();
      for (const node::Parcel& p : peers_[n]->take_outgoing()) way.back().push_back(p.bytes);
      if (n == 0) sent_ += way.back().size();
    }
  }

 private:
  void work(std::size_t n) {
    node::Participant& peer = *peers_[n];
    if (on_way_[n].size() > kDelay) {
      for (const wire::Bytes& d : on_way_[n].front()) peer.receive(place(1 - n), d, now_);
      on_way_[n].pop_front();
    }
    if (now_ >= peer.next_due()) peer.advance(now_);
    while (peer.step_due(now_)) peer.step({5, 5}, now_);
  }

  const Scene scene_ = room(20, 2);
  std::array<std::unique_ptr<node::Participant>, 2> peers_;
  std::array<std::deque<std::vector<wire::Bytes>>, 2> on_way_;  ///< to each, by turn
  Micros now_ = kMicrosPerSecond;
  std::uint64_t sent_ = 0;
  std::uint64_t counted_ = 0;
};

class WholePeer : public ::testing::TestWithParam<wire::SealMode> {};

TEST_P(WholePeer, WhatAPeerSendsIsHandedOverWithoutAllocating) {
  wire::choose_fast_code();
  Pair pair(GetParam());
  for (int i = 0; i < 20 * kTicksPerSecond; ++i) pair.turn();
  ASSERT_TRUE(pair.plays());
  const std::uint64_t sent = pair.sent();
  const std::uint64_t counted = pair.counted();
  for (int i = 0; i < 20 * kTicksPerSecond; ++i) pair.turn();
  EXPECT_GT(pair.sent(), sent + 20);
  EXPECT_EQ(pair.counted(), counted);
}

INSTANTIATE_TEST_SUITE_P(Sealed, WholePeer,
                         ::testing::Values(wire::SealMode::kNone, wire::SealMode::kAuth, wire::SealMode::kEncrypt));

}  // namespace
}  // namespace padr::bench
