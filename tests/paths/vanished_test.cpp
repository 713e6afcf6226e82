// What it costs the others that somebody is gone without a word.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/membership/party.h"
#include "tests/seed.h"

namespace padr::test {
namespace {

/// Bytes that each of the first `stay` of a session sends in its busiest second before and after one more is gone.
struct Busiest {
  double before = 0;
  double after = 0;
};

Busiest busiest_around_a_loss(wire::SealMode seal, int peers, std::uint64_t seed) {
  lab::VirtualNetworkConfig config = party_config(peers, "delay 20ms 5ms", seed);
  config.seal = seal;
  Party party(config);
  std::map<Endpoint, std::size_t> sent;
  party.net().on_datagram = [&sent](const Endpoint& from, int, std::span<const std::byte> d) {
    sent[from] += d.size() + 28;
  };
  const auto busiest = [&](int seconds) {
    double most = 0;
    for (int i = 0; i < seconds * 2; ++i) {
      sent.clear();
      party.run(0.5);
      for (int p = 0; p + 1 < peers; ++p) most = std::max(most, 2 * static_cast<double>(sent[party.net().place_of(p)]));
    }
    return most;
  };
  EXPECT_TRUE(party.run_until(10, [&] { return party.started(); })) << party.story();
  party.run(5);
  Busiest b;
  b.before = busiest(8);
  party.net().kill(peers - 1);
  b.after = busiest(6);
  EXPECT_TRUE(party.united()) << party.story();
  EXPECT_EQ(party.judge().violation(), "");
  return b;
}

// Once, with a key, each sent what it had for the one that was gone through all others in turn, and directly, too: 3
// times as much as before, and on narrow uplinks the others' worlds stood still for seconds.
TEST(Vanished, CostsTheOthersLittle) {
  for (const int peers : {3, 6, 10})
    for (const auto seal : {wire::SealMode::kNone, wire::SealMode::kAuth}) {
      const Busiest b = busiest_around_a_loss(seal, peers, test::seed(71));
      EXPECT_LT(b.after, 2 * b.before) << peers << " peers";
    }
}

}  // namespace
}  // namespace padr::test
