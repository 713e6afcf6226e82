#include <gtest/gtest.h>

#include <boost/crc.hpp>
#include <functional>

#include "tests/membership/party.h"

namespace padr::test {
namespace {

/// The same datagram as a program of another protocol version would send it.
wire::Bytes of_version(wire::Bytes datagram, unsigned version) {
  datagram[2] = static_cast<std::byte>(version << 4U | (std::to_integer<unsigned>(datagram[2]) & 0xFU));
  boost::crc_32_type crc;
  crc.process_bytes(datagram.data(), datagram.size() - wire::kTagBytes);
  const std::uint32_t tag = crc.checksum();
  for (unsigned i = 0; i < 4; ++i)
    datagram[datagram.size() - wire::kTagBytes + i] = static_cast<std::byte>(tag >> (8 * i) & 0xFFU);
  return datagram;
}

/// A founder that waits for another peer, and everything that it sends to this place.
struct Answering {
  explicit Answering(const Endpoint& to)
      : party(
            party_config(2, "delay 10ms", 1),
            [this, to](lab::VirtualNetwork& net) {
              net.on_start = [this, to](int person, node::ParticipantConfig& c) {
                if (person > 0) return;
                c.tamper = [this, to](node::Parcel p) {
                  if (same_place(p.to, to)) answers.push_back(p.bytes);
                  return std::vector{std::move(p)};
                };
              };
            },
            1) {
    party.run(0.1);
  }
  std::vector<wire::Bytes> answers;
  Party party;
};

struct Case {
  const char* name;
  std::function<void(node::ParticipantConfig&)> change;
  std::vector<std::string> words;  ///< on both sides
};

TEST(Refusal, NamesWhatDiffersOnBothSidesWithBothValues) {
  const std::vector<Case> cases{
      {"fingerprint",
       [](auto& c) { c.session.fingerprint = 0xBAD; },
       {"physics differs", "0000000000000001", "0000000000000bad"}},
      {"a Box2D that fuses",
       [](auto& c) { c.session.fingerprint = 1 + (std::uint64_t{2} << 56U); },
       {"physics differs", "0200000000000001", "the newcomer has a Box2D that fuses", "PADR_BOX2D_SOURCE"}},
      {"authority",
       [](auto& c) { c.replica.technique.authority = false; },
       {"authority rule differs", "dynamic", "avatar-only"}},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    Party party(
        party_config(2, "loss 30%", 1),
        [&](lab::VirtualNetwork& net) {
          net.on_start = [&](int person, node::ParticipantConfig& config) {
            if (person == 1) c.change(config);
          };
        },
        2);
    party.run(10);
    EXPECT_TRUE(party.net().peer(1).failed());
    EXPECT_EQ(party.replica(0).start().wanted, 2) << "the session goes on waiting";
    for (const std::string& w : c.words) {
      const std::string failure = party.net().peer(1).session().failure();
      EXPECT_NE(failure.find(w), std::string::npos) << w << " in " << failure;
      EXPECT_TRUE(party.noted(0, w)) << w << " in " << party.story();
    }
  }
}

TEST(Refusal, AnotherProtocolVersionIsToldOnBothSides) {
  const Endpoint stranger = ipv4({10, 0, 0, 9}, 7000);
  Answering g(stranger);
  const auto join = wire::seal({wire::Kind::kSession, kNoPeer, 0}, wire::encode_session(wire::Join{1, 2, 3, true, ""}));
  g.party.net().inject(stranger, 0, of_version(join, wire::kProtocolVersion + 1));
  g.party.run(0.1);
  ASSERT_EQ(g.answers.size(), 1U);
  const wire::Bytes answer = g.answers.front();
  EXPECT_LT(answer.size(), 200U) << "and so it is never answered itself";
  EXPECT_EQ(g.party.net().peer(0).session().stats().version, 1U);
  const std::string ours = std::to_string(wire::kProtocolVersion);
  const std::string next = std::to_string(wire::kProtocolVersion + 1);
  EXPECT_TRUE(g.party.noted(0, "protocol version differs: " + ours + " in the session, " + next + " in the newcomer"));

  // And what a program of this version makes of such an answer by another.
  g.party.net().kill(0);
  const int joiner = g.party.net().start(0);
  g.party.net().inject(stranger, joiner, of_version(answer, wire::kProtocolVersion + 1));
  g.party.run(0.1);
  EXPECT_FALSE(g.party.net().peer(joiner).failed()) << "not from whom we ask";
  g.party.net().inject(g.party.net().place_of(0), joiner, of_version(answer, wire::kProtocolVersion + 1));
  g.party.run(0.1);
  EXPECT_EQ(g.party.net().peer(joiner).session().failure(),
            "protocol version differs: " + next + " at 10.0.0.1:7000, " + ours + " here");
}

TEST(Refusal, VersionsDoNotAnswerEachOthersAnswers) {
  const Endpoint stranger = ipv4({10, 0, 0, 9}, 7000);
  Answering g(stranger);
  const auto refusal =
      wire::seal({wire::Kind::kSession, 0, 5}, wire::encode_session(wire::Refuse{0, std::string(400, 'x')}));
  g.party.net().inject(stranger, 0, of_version(refusal, wire::kProtocolVersion + 1));
  g.party.run(0.5);
  EXPECT_TRUE(g.answers.empty());
}

}  // namespace
}  // namespace padr::test
