#include <gtest/gtest.h>

#include <boost/crc.hpp>
#include <functional>

#include "tests/session/virtual_net.h"

namespace padr::test {
namespace {

using node::SessionPhase;

node::SessionConfig founder(int wanted) {
  node::SessionConfig c = alike(1);
  c.wanted = c.slots = wanted;
  return c;
}

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

struct Case {
  const char* name;
  std::function<void(node::SessionConfig&)> change;
  std::vector<std::string> words;  ///< on both sides
};

TEST(Refusal, NamesWhatDiffersOnBothSidesWithBothValues) {
  const std::vector<Case> cases{
      {"scene",
       [](auto& c) {
         c.scene_hash = 0xABC;
         c.scenario = "ball seed 2";
       },
       {"scenario differs", "'arena seed 1'", "000000000005ce4e", "'ball seed 2'", "0000000000000abc"}},
      {"fingerprint",
       [](auto& c) { c.fingerprint = 0xBAD; },
       {"physics differs", "0000000000000f14", "0000000000000bad"}},
      {"authority", [](auto& c) { c.authority = false; }, {"authority rule differs", "dynamic", "avatar-only"}},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    VirtualNet net(1, "loss 30%");
    net.add(1, founder(2));
    node::SessionConfig odd = alike(2);
    odd.join = place(1);
    c.change(odd);
    net.add(2, odd);
    net.run(10'000'000);
    EXPECT_EQ(net.at(2).phase(), SessionPhase::kFailed);
    EXPECT_EQ(net.at(1).phase(), SessionPhase::kGathering) << "the session goes on waiting";
    for (const std::string& w : c.words) {
      EXPECT_NE(net.at(2).failure().find(w), std::string::npos) << w << " in " << net.at(2).failure();
      EXPECT_TRUE(net.noted(1, w)) << w << " in " << net.story();
    }
  }
}

TEST(Refusal, FullAndStarted) {
  VirtualNet net(1);
  net.add(1, founder(3));
  for (const int n : {2, 3}) {
    node::SessionConfig c = alike(static_cast<std::uint64_t>(n));
    c.join = place(1);
    net.add(n, c);
  }
  net.run(300'000);  // in, but their clocks are not agreed yet
  ASSERT_TRUE(net.all(SessionPhase::kGathering));
  ASSERT_EQ(net.at(1).present(), 3);
  node::SessionConfig late = alike(9);
  late.join = place(1);
  net.add(4, late);
  net.run(100'000);
  EXPECT_NE(net.at(4).failure().find("full: 3 of 3"), std::string::npos) << net.story();
  net.remove(4);
  ASSERT_TRUE(net.run(3'000'000, [&] { return net.all(SessionPhase::kStarted); }));
  node::SessionConfig c = alike(20);
  c.join = place(1);
  net.add(11, c);
  net.run(500'000);
  EXPECT_NE(net.at(11).failure().find("already started"), std::string::npos) << net.story();
  EXPECT_TRUE(net.noted(1, "already started"));
  net.remove(11);
  // A session runs, and takes newcomers in, once a Membership has it: until then a member has nothing to say.
  c.join = place(2);
  net.add(12, c);
  net.run(500'000);
  EXPECT_EQ(net.at(12).phase(), SessionPhase::kJoining) << net.story();
}

TEST(Refusal, AnotherProtocolVersionIsToldOnBothSides) {
  VirtualNet net(1);
  net.add(1, founder(2));
  const auto join = wire::seal({wire::Kind::kSession, kNoPeer, 0}, wire::encode_session(wire::Join{1, 2, 3, true, ""}));
  net.inject(place(9), 1, of_version(join, wire::kProtocolVersion + 1));
  const auto out = net.at(1).take_outgoing();
  ASSERT_EQ(out.size(), 1U);
  EXPECT_EQ(out[0].to, place(9));
  EXPECT_LT(out[0].bytes.size(), 200U) << "and so it is never answered itself";
  EXPECT_EQ(net.at(1).stats().version, 1U);
  const auto notes = net.at(1).take_notes();
  ASSERT_FALSE(notes.empty());
  const std::string ours = std::to_string(wire::kProtocolVersion);
  const std::string next = std::to_string(wire::kProtocolVersion + 1);
  EXPECT_NE(
      notes.back().text.find("protocol version differs: " + ours + " in the session, " + next + " in the newcomer"),
      std::string::npos);

  // And what a program of this version makes of such an answer by another.
  node::SessionConfig c = alike(2);
  c.join = place(1);
  net.add(2, c);
  net.inject(place(8), 2, of_version(out[0].bytes, wire::kProtocolVersion + 1));
  EXPECT_EQ(net.at(2).phase(), SessionPhase::kJoining) << "not from whom we ask";
  net.inject(place(1), 2, of_version(out[0].bytes, wire::kProtocolVersion + 1));
  EXPECT_EQ(net.at(2).failure(), "protocol version differs: " + next + " at 10.0.0.1:7000, " + ours + " here");
}

TEST(Refusal, VersionsDoNotAnswerEachOthersAnswers) {
  VirtualNet net(1);
  net.add(1, founder(2));
  const auto refusal =
      wire::seal({wire::Kind::kSession, 0, 5}, wire::encode_session(wire::Refuse{0, std::string(400, 'x')}));
  net.inject(place(9), 1, of_version(refusal, wire::kProtocolVersion + 1));
  EXPECT_TRUE(net.at(1).take_outgoing().empty());
}

}  // namespace
}  // namespace padr::test
