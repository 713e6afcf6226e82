#include <gtest/gtest.h>

#include "common/wire/session_codec.h"
#include "tests/session/virtual_net.h"

namespace padr::test {
namespace {

using wire::decode_session;
using wire::encode_session;

wire::Roster roster(std::size_t n) {
  wire::Roster r(1);
  while (r.size() < n) r.push_back(place(static_cast<int>(r.size())));
  return r;
}

/// Members without the founder, the first of them at place `first`.
wire::Roster guests(int first, std::size_t n) {
  wire::Roster r;
  while (r.size() < n) r.push_back(place(first + static_cast<int>(r.size())));
  return r;
}

TEST(SessionCodec, EveryMessageComesBackAsItWas) {
  const std::vector<wire::SessionMessage> messages{
      wire::Join{1, 0, 0, false, ""},
      wire::Join{~0ULL, ~0ULL, ~0ULL, true, std::string(wire::kMaxLabel, 'x')},
      wire::Welcome{7, 1, 2, 2},
      wire::Welcome{7, 63, 64, 64},
      wire::Welcome{7, 0, 1, 1, true, 1, 1},
      wire::Welcome{7, 63, 64, 1, true, ~0U, ~0ULL},
      wire::Redirect{9, place(4)},
      wire::Refuse{0, ""},
      wire::Refuse{9, std::string(wire::kMaxReason, 'y')},
      wire::Ping{-wire::kMaxClock},
      wire::Ping{0},
      wire::Pong{wire::kMaxClock, -wire::kMaxClock, 64},
      wire::Start{-5, roster(1)},
      wire::Start{wire::kMaxClock, roster(32)},
      wire::Start{5, guests(20, 20), 20},
      wire::Start{5, guests(63, 1), 63},
      wire::Ready{0, false},
      wire::Ready{0xFFFFFFFF, true},
      wire::Bye{"so long"},
  };
  for (const auto& m : messages) {
    const auto back = decode_session(encode_session(m));
    ASSERT_TRUE(back) << m.index();
    EXPECT_EQ(*back, m) << m.index();
  }
}

TEST(SessionCodec, SizesKeepTheRuleOfNoLargerAnswer) {
  for (const std::size_t label :
       {std::size_t{0}, std::size_t{1}, std::size_t{127}, wire::kMaxLabel, wire::kMaxLabel + 9})
    EXPECT_EQ(encode_session(wire::Join{1, 1, 1, true, std::string(label, 'x')}).size(), wire::kMaxPayload) << label;
  EXPECT_LE(encode_session(wire::Pong{-1, -1, kMaxPeers}).size(), encode_session(wire::Ping{0}).size());
  wire::Start longest{wire::kMaxClock, guests(kMaxPeers - 20, wire::kMembersPerStart), kMaxPeers - 20};
  for (Endpoint& e : longest.members) e.key.fill(1);
  EXPECT_LE(encode_session(longest).size(), wire::kMaxPayload);
  EXPECT_LE(encode_session(wire::Refuse{~0ULL, std::string(1000, 'x')}).size(), wire::kMaxPayload);
}

TEST(SessionCodec, ValuesOutOfRangeAreRefused) {
  wire::Roster hole = roster(3);
  hole[2].port = 0;
  wire::Roster nowhere = roster(3);
  nowhere[1].address = {};
  const std::vector<wire::SessionMessage> wrong{
      wire::Join{0, 1, 1, true, ""},
      wire::Welcome{1, 0, 2, 2},
      wire::Welcome{1, 2, 2, 2},
      wire::Welcome{1, 1, 1, 2},
      wire::Welcome{1, 1, 65, 2},
      wire::Welcome{1, 1, 2, 2, false, 1},     // who is there at tick 0 is the first in its slot
      wire::Welcome{1, 1, 2, 2, true, 0, 1},   // who comes later is not
      wire::Welcome{1, 1, 2, 2, true, 1, 0},   // and proves its address
      wire::Welcome{1, 1, 2, 2, false, 0, 1},  // as others do in other ways
      wire::Welcome{1, 2, 2, 2, true, 1, 1},
      wire::Welcome{1, 1, 2, 0, true, 1, 1},
      wire::Welcome{1, 1, 2, 3, true, 1, 1},
      wire::Welcome{1, 1, 65, 2, true, 1, 1},
      wire::Redirect{1, Endpoint{}},
      wire::Ping{wire::kMaxClock + 1},
      wire::Pong{0, -wire::kMaxClock - 1, 1},
      wire::Pong{0, 0, 65},
      wire::Start{wire::kMaxClock + 1, roster(2)},
      wire::Start{0, {}},
      wire::Start{0, roster(65)},
      wire::Start{0, guests(63, 2), 63},
      wire::Start{0, guests(64, 1), 64},
      wire::Start{0, roster(2), 1},  // nobody but the founder is at no address
      wire::Start{0, hole},
      wire::Start{0, nowhere},
  };
  for (std::size_t i = 0; i < wrong.size(); ++i) EXPECT_FALSE(decode_session(encode_session(wrong[i]))) << i;
  EXPECT_FALSE(decode_session({}));
}

TEST(SessionCodec, TextsThatEndInLogsArePrintable) {
  const auto back = decode_session(encode_session(wire::Refuse{1, "a\nb\x1b[31mc\xff"}));
  ASSERT_TRUE(back);
  EXPECT_EQ(std::get<wire::Refuse>(*back).reason, "a?b?[31mc?");
}

TEST(SessionCodec, EndpointsAsPeopleWriteThem) {
  EXPECT_EQ(to_string(place(3)), "10.0.0.3:7000");
  Endpoint e;
  e.port = 1;
  EXPECT_EQ(to_string(e), "[::]:1");
  e.address[15] = 1;
  EXPECT_EQ(to_string(e), "[::1]:1");
  EXPECT_TRUE(e.is_loopback());
  e.address[0] = 0x20;
  e.address[1] = 0x01;
  e.address[2] = 0x0d;
  e.address[3] = 0xb8;
  e.address[9] = 5;
  EXPECT_EQ(to_string(e), "[2001:db8::5:0:0:1]:1");
}

}  // namespace
}  // namespace padr::test
