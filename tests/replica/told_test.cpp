// What replicas tell, and how much of it.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/model/precision.h"
#include "tests/replica/mesh.h"
#include "tests/seed.h"

namespace padr::node {
namespace {

TEST(Replica, OneDatagramPerReceiverAndTickAtMostAndNoneTooLarge) {
  Mesh mesh(3, "delay 80ms 30ms loss 20%", 4);
  std::vector<bool> running(3, true);
  for (Tick t = 0; t < 900; ++t) {
    mesh.step(running);
    for (PeerId p = 0; p < 3; ++p) {
      std::vector<int> to(3, 0);
      for (const Outgoing& o : mesh[p].outgoing()) {
        EXPECT_LE(o.bytes.size(), wire::kMaxDatagram);
        EXPECT_EQ(++to[o.to], 1);
      }
    }
  }
}

/// Bits a second, IP and UDP headers included, on the busiest directed link.
double busiest_link(Mesh& mesh, std::size_t peers, Tick ticks) {
  std::vector<std::size_t> bytes(peers * peers, 0);
  for (Tick t = 0; t < ticks; ++t) {
    mesh.step(std::vector<bool>(peers, true));
    for (PeerId p = 0; p < peers; ++p)
      for (const Outgoing& o : mesh[p].outgoing()) bytes[p * peers + o.to] += o.bytes.size() + 28;
  }
  return static_cast<double>(*std::max_element(bytes.begin(), bytes.end())) * 8 * kTicksPerSecond / ticks;
}

class QuietSession : public testing::TestWithParam<const char*> {};

TEST_P(QuietSession, TakesLessThanAKilobitASecondOnEachLinkAndWakesAtOnce) {
  const std::uint64_t base = test::seed(1);
  for (std::uint64_t seed = base; seed < base + 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    constexpr PeerId kPeers = 3;
    Mesh mesh(kPeers, GetParam(), seed);
    busiest_link(mesh, kPeers, 600);
    mesh.settle();
    busiest_link(mesh, kPeers, 600);
    EXPECT_LT(busiest_link(mesh, kPeers, 60 * kTicksPerSecond), 1000);
    const Tick before = mesh[0].agreed().confirmed().tick;
    EXPECT_GT(before, mesh.now() - 90) << "what is confirmed follows by the marks";
    mesh.wake();
    EXPECT_GT(busiest_link(mesh, kPeers, 300), 1000);
    for (PeerId p = 0; p < kPeers; ++p) {
      EXPECT_GT(mesh[p].stats().hash_checks, 60U);
      EXPECT_EQ(mesh[p].stats().hash_mismatches, 0U);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Replica, QuietSession, testing::Values("", "delay 100ms 20ms", "delay 100ms 20ms loss 1%"));

// Once, each of 21 peers was told 15 hashes a second.
TEST(Replica, ALargeSessionComparesNoMoreHashesThanASmallOneAndAsSoon) {
  for (const int peers : {6, 13, 21}) {
    SCOPED_TRACE(std::to_string(peers) + " peers");
    constexpr Tick kSeconds = 30;
    Mesh mesh(peers, "delay 100ms", test::seed(1), {}, "pitch");
    const std::vector<bool> all(static_cast<std::size_t>(peers), true);
    for (Tick t = 0; t < 5 * kTicksPerSecond; ++t) mesh.step(all);
    std::vector<std::uint64_t> compared(all.size());
    std::vector<Tick> latest(all.size(), mesh.now());
    for (PeerId p = 0; p < peers; ++p) compared[p] = mesh[p].stats().hash_checks;
    std::vector<std::uint64_t> seen = compared;
    for (Tick t = 0; t < kSeconds * kTicksPerSecond; ++t) {
      mesh.step(all);
      for (PeerId p = 0; p < peers; ++p) {
        if (mesh[p].stats().hash_checks > seen[p]) latest[p] = mesh.now();
        seen[p] = mesh[p].stats().hash_checks;
        ASSERT_LT(mesh.now() - latest[p], 3 * kTicksPerSecond / 2) << "peer " << int{p};
      }
    }
    for (PeerId p = 0; p < peers; ++p) {
      const auto a_second = static_cast<double>(seen[p] - compared[p]) / kSeconds;
      EXPECT_GE(a_second, peers == 6 ? 3 : 8) << "peer " << int{p};
      EXPECT_LE(a_second, 12) << "peer " << int{p};
    }
  }
}

/// Updates of this tick as told to somebody, by peer.
void for_each_told(const Mesh& mesh, PeerId p, const auto& look) {
  if (mesh[p].outgoing().empty()) return;
  wire::SealError error{};
  const auto opened = wire::open(mesh[p].outgoing()[0].bytes, error);
  const auto packet = wire::decode_state(opened->payload, p);
  for (const sync::Bundle& b : packet->updates)
    if (b.tick == mesh.now()) look(b, *packet);
}

// What is told is what holds for everybody from then on: predicted and, of what is still its own, the teller's live
// world. Nothing comes to rest elsewhere than told.
TEST(Rounding, WhoTellsRoundedStatesTakesThemOn) {
  const std::uint64_t base = test::seed(1);
  std::size_t bodies = 0;
  std::size_t avatars = 0;
  for (std::uint64_t seed = base; seed < base + 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Mesh mesh(3, "delay 60ms 20ms loss 5%", seed);
    for (Tick t = 0; t < 1200; ++t) {
      mesh.step(std::vector<bool>(3, true));
      for (PeerId p = 0; p < 3; ++p) {
        const Replica& n = mesh[p];
        for_each_told(mesh, p, [&](const sync::Bundle& b, const sync::StatePacket&) {
          for (const sync::BodyUpdate& u : b.bodies) {
            if (!u.has_state || n.agreed().predicted_state().authority[u.body].holder() != p) continue;
            ++bodies;
            if (u.state.awake && b.avatar && b.avatar->cause != sync::Cause::kAtRest) {
              EXPECT_EQ(u.state, rounded(u.state));
            }
            EXPECT_EQ(n.live().world().state(u.body), u.state) << "body " << u.body << " at " << t;
          }
          if (!b.avatar) return;
          ++avatars;
          if (b.avatar->cause != sync::Cause::kAtRest) {
            EXPECT_EQ(b.avatar->position, rounded_place(b.avatar->position));
          }
          EXPECT_EQ(n.live().world().position(n.live().avatar()), b.avatar->position);
          EXPECT_EQ(n.live().world().velocity(n.live().avatar()), b.avatar->velocity);
        });
      }
    }
    mesh.settle();
    for (Tick t = 0; t < 1800; ++t) mesh.step(std::vector<bool>(3, true));
    for (PeerId p = 0; p < 3; ++p) {
      const sync::FoldState& predicted = mesh[p].agreed().predicted_state();
      EXPECT_GT(mesh[p].stats().hash_checks, 100U);
      EXPECT_EQ(mesh[p].stats().hash_mismatches, 0U);
      EXPECT_EQ(mesh[p].live_hash(), state_hash(predicted)) << "to the bit, in the end";
      EXPECT_EQ(mesh[p].live_hash(), mesh[0].live_hash());
    }
  }
  EXPECT_GT(bodies, 100U);
  EXPECT_GT(avatars, 100U);
}

/// Mean bytes that a moving body's state adds to its datagram, in play.
double bytes_of_a_body(const Technique& technique) {
  Mesh mesh(3, "delay 60ms 20ms loss 5%", test::seed(1), technique, "clutter");
  double bytes = 0;
  double bodies = 0;
  for (Tick t = 0; t < 2400; ++t) {
    mesh.step(std::vector<bool>(3, true));
    for (PeerId p = 0; p < 3; ++p)
      for_each_told(mesh, p, [&](const sync::Bundle& b, const sync::StatePacket& packet) {
        sync::StatePacket with = packet;
        with.updates = {b};
        sync::StatePacket without = with;
        std::erase_if(without.updates[0].bodies,
                      [](const sync::BodyUpdate& u) { return u.has_state && u.state.awake; });
        bytes += static_cast<double>(wire::encode(with).size() - wire::encode(without).size());
        bodies += static_cast<double>(b.bodies.size() - without.updates[0].bodies.size());
      });
  }
  EXPECT_GT(bodies, 50);
  return bytes / bodies;
}

TEST(Rounding, AMovingBodyTakesNoMoreThanItsFloats) {
  EXPECT_LE(bytes_of_a_body({}), 24);
  Technique exact;
  exact.precision = Precision::kExact;
  EXPECT_GT(bytes_of_a_body(exact), 26);
}

}  // namespace
}  // namespace padr::node
