// What a third peer carries for two: who may read, forge, repeat or use it.
#include <algorithm>
#include <array>
#include <deque>
#include <functional>

#include "common/wire/sealed.h"
#include "tests/channel/two_peers.h"
#include "tests/seed.h"

namespace padr::test {
namespace {

using node::ChannelDrop;

/// By the carrier, and by strangers: 10^6 in all.
constexpr int kForgeries = 500'000;

/// Three peers at the places 1, 2 and 3 that all know one another. Whoever tests carries everything.
struct Three {
  explicit Three(wire::SealMode mode = wire::SealMode::kAuth) {
    for (const std::size_t n : {0U, 1U, 2U}) {
      node::ChannelConfig c = channel_config(10 + n, mode);
      c.may_carry = [this](const Endpoint& from, const Endpoint& to, std::size_t) {
        asked.emplace_back(from, to);
        return carries;
      };
      if (n == 2)
        c.on_key = [this](const PublicKey&, const PublicKey& to, const wire::Key& key) {
          if (to == peers[1].key()) to_1 = key;
        };
      peers.emplace_back(std::move(c));
    }
    for (const std::size_t from : {0U, 1U, 2U})
      for (const std::size_t to : {0U, 1U, 2U})
        if (from != to) peers[from].send(name_of(to), kNoPeer, words("hello"), now);
    settle();
    heard = {};
  }
  Endpoint name_of(std::size_t n) const {
    Endpoint e = place(static_cast<int>(n) + 1);
    e.key = peers[n].key();
    return e;
  }
  bool deliver(std::size_t to, std::size_t from, std::span<const std::byte> bytes) {
    const auto arrival = peers[to].receive(place(static_cast<int>(from) + 1), bytes, now);
    if (!arrival) return false;
    heard[to].emplace_back(arrival->datagram.begin(), arrival->datagram.end());
    from_whom = arrival->from;
    was_carried = arrival->carried;
    return true;
  }
  std::size_t at(const Endpoint& where) const {
    for (const std::size_t n : {0U, 1U, 2U})
      if (same_place(where, place(static_cast<int>(n) + 1))) return n;
    return 3;
  }
  void settle() {
    for (int i = 0; i < 20; ++i)
      for (const std::size_t n : {0U, 1U, 2U})
        for (const auto& p : taken(peers[n])) deliver(at(p.to), n, p.bytes);
  }
  /// What 0 says to 1 by 2, as it goes out to 2.
  wire::Bytes by_2(std::string_view text) {
    peers[0].carry(peers[1].key(), peers[2].key(), false, now);
    peers[0].send(name_of(1), kNoPeer, words(text), now);
    for (const auto& p : taken(peers[0]))
      if (same_place(p.to, place(3))) return p.bytes;
    ADD_FAILURE() << "nothing goes to 2";
    return {};
  }
  std::uint64_t dropped(std::size_t n, ChannelDrop why) const {
    return peers[n].stats().dropped[static_cast<std::size_t>(why)];
  }

  std::deque<node::SecureChannels> peers;
  Micros now = kMicrosPerSecond;
  bool carries = true;
  std::vector<std::pair<Endpoint, Endpoint>> asked;
  std::array<std::vector<wire::Bytes>, 3> heard;
  Endpoint from_whom;
  bool was_carried = false;
  wire::Key to_1{};  ///< what 2 seals with for 1, in the end
};

class CarriedModes : public testing::TestWithParam<wire::SealMode> {};

TEST_P(CarriedModes, ArriveAsIfTheyHadComeDirectly) {
  Three t(GetParam());
  const wire::Bytes first = t.by_2("by another");
  EXPECT_FALSE(t.deliver(2, 0, first)) << "it is not for the carrier";
  const auto second = taken(t.peers[2]);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_TRUE(same_place(second[0].to, place(2)));
  EXPECT_LE(second[0].bytes.size(), first.size()) << "nothing grows on its way";
  ASSERT_TRUE(t.deliver(1, 2, second[0].bytes));
  EXPECT_EQ(t.heard[1].back(), words("by another"));
  EXPECT_EQ(t.from_whom.key, t.peers[0].key());
  EXPECT_TRUE(t.was_carried);
  EXPECT_EQ(t.peers[2].stats().carried, 1U);
  ASSERT_EQ(t.asked.size(), 1U);
  EXPECT_EQ(t.asked[0].first.key, t.peers[0].key());
  EXPECT_EQ(t.asked[0].second.key, t.peers[1].key());
  // Who has carried it is not where its sender is.
  t.peers[1].send(t.name_of(0), kNoPeer, words("back"), t.now);
  EXPECT_TRUE(same_place(taken(t.peers[1]).at(0).to, place(1)));
}

INSTANTIATE_TEST_SUITE_P(Each, CarriedModes, testing::Values(wire::SealMode::kAuth, wire::SealMode::kEncrypt),
                         [](const auto& mode) { return mode.param == wire::SealMode::kAuth ? "auth" : "encrypt"; });

TEST(Carried, TheLargestDatagramFits) {
  Three t;
  const std::string much(wire::kMaxPayload, 'x');
  const wire::Bytes first = t.by_2(much);
  EXPECT_EQ(first.size(), wire::kMaxCarried);
  t.deliver(2, 0, first);
  EXPECT_TRUE(t.deliver(1, 2, taken(t.peers[2]).at(0).bytes));
}

TEST(Carried, TheCarrierCannotRepeatOrChangeOrMakeThem) {
  Three t;
  const wire::Bytes first = t.by_2("once");
  t.deliver(2, 0, first);
  const wire::Bytes second = taken(t.peers[2]).at(0).bytes;
  ASSERT_TRUE(t.deliver(1, 2, second));
  EXPECT_FALSE(t.deliver(1, 2, second)) << "the carrier's own datagram again";
  // The carrier seals what it has once more, changed or not.
  std::uint64_t number = wire::read_sealed(second)->number;
  const auto outer = wire::unseal_with(t.to_1, number, second);
  ASSERT_TRUE(outer);
  const auto inside = wire::decode_carried(*outer)->sealed;
  const wire::Bytes inner(inside.begin(), inside.end());
  const auto sealed_again = [&](const wire::Bytes& what) {
    wire::Bytes plain;
    wire::encode_carried({wire::short_id(t.peers[1].key()), what}, plain);
    return wire::seal_with(t.to_1, wire::SealMode::kAuth, wire::short_id(t.peers[2].key()), ++number, plain);
  };
  const std::uint64_t replays = t.dropped(1, ChannelDrop::kReplay);
  EXPECT_FALSE(t.deliver(1, 2, sealed_again(inner)));
  EXPECT_EQ(t.dropped(1, ChannelDrop::kReplay), replays + 1);
  Rng rng(test::seed());
  for (int i = 0; i < kForgeries; ++i) {
    wire::Bytes changed = inner;
    for (std::uint32_t n = 1 + rng.below(3); n > 0; --n)
      changed[rng.below(static_cast<std::uint32_t>(changed.size()))] ^= static_cast<std::byte>(1 + rng.below(255));
    ASSERT_FALSE(changed != inner && t.deliver(1, 2, sealed_again(changed))) << i;
  }
  // One hop: a carried one in a carried one goes nowhere.
  wire::Bytes plain;
  wire::encode_carried({wire::short_id(t.peers[1].key()), inner}, plain);
  const wire::Bytes nested =
      wire::seal_with(t.to_1, wire::SealMode::kAuth, wire::short_id(t.peers[2].key()), ++number, plain);
  if (nested.size() <= wire::kMaxSealed) {
    const std::uint64_t forms = t.dropped(1, ChannelDrop::kForm);
    EXPECT_FALSE(t.deliver(1, 2, sealed_again(nested)));
    EXPECT_EQ(t.dropped(1, ChannelDrop::kForm), forms + 1);
  }
}

TEST(Carried, OnlyForWhomTheCarrierAllows) {
  Three t;
  t.carries = false;
  t.deliver(2, 0, t.by_2("refused"));
  EXPECT_TRUE(taken(t.peers[2]).empty());
  EXPECT_EQ(t.peers[2].stats().declined, 1U);
  t.carries = true;
  t.deliver(2, 0, t.by_2("taken"));
  EXPECT_EQ(taken(t.peers[2]).size(), 1U);
  t.now += 3 * kMicrosPerSecond;  // nothing has come from 1 for so long
  t.deliver(2, 0, t.by_2("not heard"));
  EXPECT_EQ(t.peers[2].stats().declined, 1U) << "the link may work in this direction only";
}

// What is carried goes over the link to the carrier, and then over the carrier's own.
TEST(Carried, GoesOverTheLinkOfWhoCarries) {
  Three t;
  const auto number = [](std::size_t n) { return static_cast<PeerId>(20 + n); };
  for (const std::size_t to : {1U, 2U}) t.peers[0].send(t.name_of(to), number(to), words("state"), t.now);
  t.peers[2].send(t.name_of(1), number(1), words("state"), t.now);
  t.settle();
  t.peers[0].carry(t.peers[1].key(), t.peers[2].key(), false, t.now);
  t.peers[0].send(t.name_of(1), number(1), words("carried"), t.now);
  const auto out = taken(t.peers[0]);
  ASSERT_EQ(out.size(), 1U);
  EXPECT_TRUE(same_place(out[0].to, place(3)));
  EXPECT_EQ(out[0].state_to, number(2));
  t.deliver(2, 0, out[0].bytes);
  const auto on = taken(t.peers[2]);
  ASSERT_EQ(on.size(), 1U);
  EXPECT_EQ(on[0].state_to, number(1));
}

// Both arrive, as two datagrams.
TEST(Carried, DirectlyTooIfNobodyKnowsWhatWorks) {
  Three t;
  t.peers[0].carry(t.peers[1].key(), t.peers[2].key(), true, t.now);
  t.peers[0].send(t.name_of(1), 1, words("twice"), t.now);
  const auto out = taken(t.peers[0]);
  ASSERT_EQ(out.size(), 2U);
  t.deliver(2, 0, out[0].bytes);
  EXPECT_TRUE(t.deliver(1, 2, taken(t.peers[2]).at(0).bytes));
  EXPECT_TRUE(t.deliver(1, 0, out[1].bytes));
  EXPECT_FALSE(t.was_carried);
  EXPECT_EQ(t.heard[1], (std::vector<wire::Bytes>(2, words("twice"))));
}

// What a stranger sends goes nowhere, however often.
TEST(Carried, NotForStrangers) {
  Three t;
  const wire::Bytes good = t.by_2("good");
  Rng rng(test::seed());
  std::size_t in = 0;
  std::size_t out = 0;
  for (int i = 0; i < kForgeries; ++i) {
    wire::Bytes d = good;
    d[rng.below(static_cast<std::uint32_t>(d.size()))] ^= static_cast<std::byte>(1 + rng.below(255));
    in += d.size();
    ASSERT_FALSE(t.peers[2].receive(place(9), d, t.now));
    for (const auto& p : taken(t.peers[2])) out += p.bytes.size();
  }
  EXPECT_EQ(t.peers[2].stats().carried, 0U);
  EXPECT_LE(out, in);
}

// Whether a link works again is tried with a number of its own, or the receiver could not tell.
TEST(Carried, TheDirectWayIsTriedNowAndThen) {
  Three t;
  std::vector<double> tried;
  for (int i = 0; i < 60 * 40; ++i) {
    t.now += 16'667;
    t.peers[0].carry(t.peers[1].key(), t.peers[2].key(), false, t.now);
    t.peers[0].send(t.name_of(1), 1, words("tick " + std::to_string(i)), t.now);
    for (const auto& p : taken(t.peers[0])) {
      if (!same_place(p.to, place(2))) continue;
      if (wire::read_sealed(p.bytes)) tried.push_back(static_cast<double>(t.now) / 1e6);
    }
    // It goes on hearing both.
    for (const std::size_t n : {1U, 2U}) {
      t.peers[n].send(t.name_of(0), kNoPeer, words("here"), t.now);
      for (const auto& p : taken(t.peers[n])) t.deliver(0, n, p.bytes);
    }
  }
  ASSERT_GE(tried.size(), 6U);
  const std::array<double, 5> between{2, 4, 4, 4, 4};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(tried[i + 1] - tried[i], between[i], 0.1) << i;
  t.now += node::SecureChannels::kCarries;
  t.peers[0].send(t.name_of(1), 1, words("again"), t.now);
  EXPECT_TRUE(same_place(taken(t.peers[0]).at(0).to, place(2)));
}

/// What 0 says to 1 in a tick, carried by 2, while 1 says that it is at place 11, too; 0 goes on hearing 2. Returns
/// what goes anywhere but to 2.
std::vector<node::Parcel> tick_with_elsewhere(Three& t) {
  const std::array elsewhere{place(11)};
  t.now += 16'667;
  t.peers[0].carry(t.peers[1].key(), t.peers[2].key(), false, t.now, elsewhere);
  t.peers[0].send(t.name_of(1), 1, words("tick"), t.now);
  std::vector<node::Parcel> out;
  for (const auto& p : taken(t.peers[0]))
    if (!same_place(p.to, place(3))) out.push_back(p);
  for (const std::size_t n : {1U, 2U}) {
    t.peers[n].send(t.name_of(0), kNoPeer, words("here"), t.now);
    for (const auto& p : taken(t.peers[n])) t.deliver(0, n, p.bytes);
  }
  return out;
}

/// Until 0 asks at place 11 whether 1 is there; then `somebody` gets that, and 0 the answer.
void asks_elsewhere(Three& t, node::SecureChannels& somebody, const std::function<void()>& afterwards) {
  bool asked = false;
  for (int i = 0; i < 600 && !asked; ++i)
    for (const auto& p : tick_with_elsewhere(t)) {
      if (!same_place(p.to, place(11))) continue;
      asked = true;
      somebody.receive(place(1), p.bytes, t.now);
      for (const auto& q : taken(somebody)) t.peers[0].receive(place(11), q.bytes, t.now);
      afterwards();
    }
  ASSERT_TRUE(asked);
  t.now += node::SecureChannels::kCarries;
  t.peers[0].send(t.name_of(1), 1, words("directly"), t.now);
}

// Where a peer says that it is, as often as the direct way is tried, and no more.
TEST(CarriedElsewhere, IsAskedAsOftenAsTheDirectWay) {
  Three t;
  int tries = 0;
  int hellos = 0;
  for (int i = 0; i < 60 * 20; ++i)
    for (const auto& p : tick_with_elsewhere(t)) {
      if (same_place(p.to, place(2)) && wire::read_sealed(p.bytes)) ++tries;
      if (!same_place(p.to, place(11))) continue;
      EXPECT_TRUE(wire::is_handshake(p.bytes));
      ++hellos;
    }
  EXPECT_GE(tries, 5);
  EXPECT_LE(tries, 8);
  EXPECT_EQ(hellos, tries);
}

TEST(CarriedElsewhere, IsWhereItIsOnceItAnswersThere) {
  Three t;
  asks_elsewhere(t, t.peers[1], [&t] {
    for (const auto& q : taken(t.peers[0])) EXPECT_TRUE(same_place(q.to, place(11))) << "the introduction";
  });
  const auto out = taken(t.peers[0]);
  EXPECT_TRUE(std::any_of(out.begin(), out.end(), [](const auto& p) { return same_place(p.to, place(11)); }));
}

// Somebody else who has the session's key, at that address of another LAN.
TEST(CarriedElsewhere, SomebodyElseThereIsNotIt) {
  Three t;
  node::SecureChannels stranger(channel_config(99));
  asks_elsewhere(t, stranger, [&t] { EXPECT_TRUE(taken(t.peers[0]).empty()); });
  for (const auto& p : taken(t.peers[0])) EXPECT_TRUE(same_place(p.to, place(2)));
}

}  // namespace
}  // namespace padr::test
