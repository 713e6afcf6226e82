// A newcomer asks a member, and the coordinator is where a newcomer does not get through by itself.
#include "common/paths/introductions.h"
#include "tests/membership/party.h"
#include "tests/membership/rules.h"
#include "tests/seed.h"

namespace padr::test {
namespace {

using node::Introductions;

/// s in which a newcomer comes in, by a real clock that is kept.
constexpr double kComesInWithin = 3;
constexpr int kCoordinator = 0, kAsked = 1, kNewcomer = 2;

/// Two members, and the newcomer begins to ask the second one. Neither way between it and the coordinator works.
struct Separated {
  explicit Separated(bool sealed, const std::string& netem = "delay 30ms 5ms loss 1%") : party(config(sealed, netem)) {
    party.net().on_datagram = [this](const Endpoint& from, int to, std::span<const std::byte> datagram) {
      if (on_datagram) on_datagram(from, to, datagram);
    };
    party.run(5);
    cut(true, true);
    EXPECT_EQ(party.net().start(kAsked), kNewcomer);
  }
  static lab::VirtualNetworkConfig config(bool sealed, const std::string& netem) {
    lab::VirtualNetworkConfig c = party_config(2, netem, test::seed(91));
    if (sealed) c.seal = wire::SealMode::kAuth;
    return c;
  }
  void cut(bool there, bool back) {
    party.net().cut(kCoordinator, kNewcomer, there);
    party.net().cut(kNewcomer, kCoordinator, back);
  }
  /// NATs from now on: what one of the two sends lets in what the other one sends.
  void open_by_knocking(bool coordinators, bool newcomers) {
    cut(newcomers, coordinators);
    on_datagram = [=, this](const Endpoint& from, int to, std::span<const std::byte> /*datagram*/) {
      const auto is = [&](int a, int b) { return same_place(from, party.net().place_of(a)) && to == b; };
      if (is(kCoordinator, kNewcomer)) party.net().cut(kNewcomer, kCoordinator, false);
      if (is(kNewcomer, kCoordinator)) party.net().cut(kCoordinator, kNewcomer, false);
    };
  }
  std::uint64_t carried() const {
    const node::SecureChannels* c = party.net().peer(kAsked).channels();
    return c == nullptr ? 0 : c->stats().carried;
  }
  void comes_in() {
    const auto took = party.run_until(8, [&] { return party.united(); });
    ASSERT_TRUE(took) << party.story();
    EXPECT_LT(*took, kComesInWithin) << party.story();
  }
  void stays() { party.expect_to_stay(3); }

  Party party;
  std::function<void(const Endpoint& from, int to, std::span<const std::byte>)> on_datagram;
};

class Introduced : public testing::TestWithParam<bool> {};

TEST_P(Introduced, ToACoordinatorThatGetsOnlyAnswers) {
  Separated c(GetParam());
  c.open_by_knocking(true, false);
  c.comes_in();
  EXPECT_EQ(c.carried(), 0U);
  c.stays();
}

TEST_P(Introduced, BothGetOnlyAnswers) {
  Separated c(GetParam());
  c.open_by_knocking(true, true);
  c.comes_in();
  c.stays();
}

INSTANTIATE_TEST_SUITE_P(Sealed, Introduced, testing::Bool(),
                         [](const auto& p) { return p.param ? "with_a_key" : "without_a_key"; });

// As two of different families, or behind two symmetric NATs: the member that was asked carries, before and after.
TEST(IntroducedBy, WhoCarriesWhenNothingPasses) {
  Separated c(true);
  c.comes_in();
  c.stays();
  EXPECT_NE(c.party.net().peer(kCoordinator).carrier(c.party.replica(kNewcomer).self()), kNoPeer);
  EXPECT_GT(c.carried(), 100U);
}

TEST(IntroducedBy, WhoCarriesOverALongAndBadLink) {
  Separated c(true, "delay 100ms 20ms loss 5%");
  const auto took = c.party.run_until(12, [&] { return c.party.united(); });
  ASSERT_TRUE(took) << c.party.story();
  EXPECT_LT(*took, 8);
  EXPECT_EQ(c.party.judge().violation(), "");
}

TEST(IntroducedBy, WhoCarriesWhenOnlyOneWayPasses) {
  for (const bool there : {false, true}) {
    SCOPED_TRACE(there);
    Separated c(true);
    c.cut(there, !there);
    c.comes_in();
    c.stays();
  }
}

// A second newcomer: what the first one has used up does not keep it out.
TEST(IntroducedBy, WhoCarriesForOneAfterTheOther) {
  Separated c(true);
  c.comes_in();
  for (int next = kNewcomer + 1; next < kNewcomer + 4; ++next) {
    c.party.net().cut(kCoordinator, next, true);
    c.party.net().cut(next, kCoordinator, true);
    ASSERT_EQ(c.party.net().start(kAsked), next);
    c.comes_in();
  }
  EXPECT_EQ(c.party.judge().violation(), "");
}

// In a session without a key nobody carries: whoever did could say anything.
TEST(IntroducedBy, NobodyWithoutAKey) {
  Separated c(false);
  EXPECT_FALSE(c.party.run_until(8, [&] { return c.party.united(); }));
  EXPECT_FALSE(c.party.net().peer(kNewcomer).playing());
}

// ---- the rules alone

Endpoint keyed(int p) {
  Endpoint e = Situation::at(p);
  e.key.fill(static_cast<std::uint8_t>(1 + p));
  return e;
}

wire::Join a_join() {
  wire::Join join;
  join.nonce = 7;
  return join;
}

TEST(IntroductionRules, WhoIsToldWhat) {
  for (const bool sealed : {false, true}) {
    Situation s(2, 1);
    s.session.config.sealed = sealed;
    const Endpoint newcomer = sealed ? keyed(9) : Situation::at(9);
    const Endpoint coordinator = sealed ? keyed(0) : Situation::at(0);
    Introductions member(s.session);
    ListedCommands out;
    member.redirect(newcomer, a_join(), coordinator, 0, out);
    ASSERT_EQ(out.all<wire::Redirect>().size(), 1U);
    EXPECT_EQ(out.all<wire::Redirect>()[0].to, newcomer);
    ASSERT_EQ(out.all<wire::Newcomer>().size(), 1U);
    EXPECT_EQ(out.all<wire::Newcomer>()[0].to, coordinator);
    EXPECT_EQ(out.all<wire::Newcomer>()[0].message.at, newcomer);
    EXPECT_EQ(member.may_carry(newcomer, coordinator), sealed);
    EXPECT_EQ(member.may_carry(coordinator, newcomer), sealed);
    EXPECT_FALSE(member.may_carry(newcomer, keyed(3)));
    EXPECT_FALSE(member.may_carry(keyed(3), coordinator));

    Introductions at_the_coordinator(s.session);
    ListedCommands answer;
    at_the_coordinator.on_newcomer(Situation::at(1), wire::Newcomer{newcomer}, 0, answer);
    // With a key the channel sends something there.
    EXPECT_EQ(answer.all<wire::Newcomer>().size(), sealed ? 0U : 1U);
    EXPECT_EQ(at_the_coordinator.introduced().size(), sealed ? 1U : 0U);
  }
}

TEST(IntroductionRules, NothingBeyondTheRateLimitNorOfAnotherSort) {
  Situation s(2, 1);
  s.session.config.sealed = true;
  Introductions i(s.session);
  ListedCommands out;
  i.on_newcomer(Situation::at(1), wire::Newcomer{Situation::at(9)}, 0, out);
  EXPECT_TRUE(i.introduced().empty()) << "without a key";
  out.answers = false;
  i.on_newcomer(Situation::at(1), wire::Newcomer{keyed(9)}, 0, out);
  i.redirect(keyed(9), a_join(), keyed(0), 0, out);
  EXPECT_TRUE(i.introduced().empty());
  EXPECT_TRUE(out.all<wire::Newcomer>().empty());
  EXPECT_TRUE(out.all<wire::Redirect>().empty());
  EXPECT_FALSE(i.may_carry(keyed(9), keyed(0)));
}

TEST(IntroductionRules, LastForALeaseAndTheLatestOnes) {
  Situation s(2, 1);
  s.session.config.sealed = true;
  Introductions i(s.session);
  ListedCommands out;
  constexpr auto kMost = static_cast<int>(Introductions::kMost);
  for (int n = 0; n <= kMost; ++n) i.redirect(keyed(10 + n), a_join(), keyed(0), 0, out);
  EXPECT_FALSE(i.may_carry(keyed(10), keyed(0)));
  EXPECT_TRUE(i.may_carry(keyed(11), keyed(0)));
  i.redirect(keyed(11), a_join(), keyed(0), 1, out);  // again
  EXPECT_TRUE(i.may_carry(keyed(12), keyed(0))) << "nobody makes room for one that is there";
  i.advance(Introductions::kLease);
  EXPECT_TRUE(i.may_carry(keyed(12), keyed(0)));
  i.advance(Introductions::kLease + 1);
  EXPECT_FALSE(i.may_carry(keyed(12), keyed(0)));
  EXPECT_TRUE(i.may_carry(keyed(11), keyed(0)));
  i.advance(Introductions::kLease + 2);
  EXPECT_FALSE(i.may_carry(keyed(11), keyed(0)));
}

// A loopback address is on the machine of who tells it.
TEST(IntroductionRules, ANewcomerOnAMembersOwnMachineIsThere) {
  Situation s(2, 0);
  Introductions i(s.session);
  ListedCommands out;
  i.on_newcomer(Situation::at(1), wire::Newcomer{ipv4({127, 0, 0, 1}, 99)}, 0, out);
  ASSERT_EQ(out.all<wire::Newcomer>().size(), 1U);
  EXPECT_EQ(out.all<wire::Newcomer>()[0].to, ipv4({10, 0, 0, 2}, 99));
}

}  // namespace
}  // namespace padr::test
