// Who is given several members to join by.
#include <gtest/gtest.h>

#include "tests/membership/party.h"
#include "tests/seed.h"

namespace padr::test {
namespace {

Endpoint nobody(std::uint8_t host) {
  return ipv4({10, 0, 0, host}, 7000);
}

/// Two who play.
lab::VirtualNetworkConfig two(wire::SealMode seal, const std::string& netem) {
  lab::VirtualNetworkConfig config = party_config(2, netem, seed(3));
  config.seal = seal;
  return config;
}

/// One more comes, by these in turn.
int start(Party& party, std::vector<Endpoint> by) {
  party.net().on_start = [&](int, node::ParticipantConfig& c) {
    c.session.join = by.front();
    c.session.others.assign(by.begin() + 1, by.end());
  };
  const int n = party.net().start(0);
  party.net().on_start = nullptr;
  return n;
}

// Of a slow link the answer comes when the next one has got its turn; from turn to turn it has more time.
TEST(Contacts, WhereNobodyAnswersTheNextOneIsAsked) {
  for (const auto seal : {wire::SealMode::kNone, wire::SealMode::kAuth})
    for (const char* netem : {"delay 10ms", "delay 600ms"}) {
      Party party(two(seal, netem));
      ASSERT_TRUE(party.run_until(20, [&] { return party.started(); })) << party.story();
      const int late = start(party, {nobody(50), nobody(51), party.net().place_of(1)});
      ASSERT_TRUE(party.run_until(20, [&] { return party.net().peer(late).playing(); })) << netem << party.story();
      party.run(4);
      EXPECT_TRUE(party.united()) << party.story();
      EXPECT_EQ(party.judge().violation(), "");
    }
}

// The one that has welcomed it ends before it has let it in. It knows no other member but by its command line.
TEST(Contacts, WhoeverIsLetDownByOneAsksTheNext) {
  for (const auto seal : {wire::SealMode::kNone, wire::SealMode::kAuth}) {
    Party party(two(seal, "delay 40ms 10ms"));
    ASSERT_TRUE(party.run_until(20, [&] { return party.started(); })) << party.story();
    const int late = start(party, {party.net().place_of(0), party.net().place_of(1)});
    const node::Session& session = party.net().peer(late).session();
    ASSERT_TRUE(party.run_until(5, [&] { return session.phase() == node::SessionPhase::kEntering; }));
    party.net().kill(0);
    ASSERT_TRUE(party.run_until(20, [&] { return party.net().peer(late).playing(); })) << party.story();
    party.run(4);
    EXPECT_TRUE(party.united()) << party.story();
    EXPECT_EQ(party.judge().violation(), "");
  }
}

TEST(Contacts, WhoGetsNoAnswerNamesThemAll) {
  Party party(two(wire::SealMode::kNone, "delay 10ms"));
  ASSERT_TRUE(party.run_until(20, [&] { return party.started(); })) << party.story();
  start(party, {nobody(50), nobody(51)});
  party.run(12);
  const std::string story = party.story();
  const bool is_named =
      story.find("no answer from 10.0.0.50:7000 or 10.0.0.51:7000 within 10 s; it may have") != std::string::npos ||
      story.find("no answer from 10.0.0.51:7000 or 10.0.0.50:7000 within 10 s; it may have") != std::string::npos;
  EXPECT_TRUE(is_named) << story;
}

}  // namespace
}  // namespace padr::test
