#include <gtest/gtest.h>

#include "common/wire/session_codec.h"

namespace padr::test {
namespace {

Endpoint place(int n) {
  return ipv4({10, 0, 0, static_cast<std::uint8_t>(n)}, 7000);
}

using wire::decode_session;
using wire::encode_session;

TEST(SessionCodec, EveryMessageComesBackAsItWas) {
  const std::vector<wire::SessionMessage> messages{
      wire::Join{1, 0, 0, false, ""},
      wire::Join{~0ULL, ~0ULL, ~0ULL, true, std::string(wire::kMaxLabel, 'x')},
      wire::Welcome{7, 0, 1, 1, 1, 1},
      wire::Welcome{7, 63, 64, 1, ~0U, ~0ULL},
      wire::Welcome{7, 63, 64, 1, ~0U, ~0ULL, {0, 0, 3}},
      wire::Redirect{9, place(4)},
      wire::Refuse{0, ""},
      wire::Refuse{9, std::string(wire::kMaxReason, 'y')},
      wire::Ping{-wire::kMaxClock},
      wire::Ping{0},
      wire::Pong{wire::kMaxClock, -wire::kMaxClock},
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
  EXPECT_LE(encode_session(wire::Pong{-1, -1}).size(), encode_session(wire::Ping{0}).size());
  EXPECT_LE(encode_session(wire::Refuse{~0ULL, std::string(1000, 'x')}).size(), wire::kMaxPayload);
}

TEST(SessionCodec, ValuesOutOfRangeAreRefused) {
  const std::vector<wire::SessionMessage> wrong{
      wire::Join{0, 1, 1, true, ""},       wire::Welcome{1, 1, 2, 2, 0, 1}, wire::Welcome{1, 1, 2, 2, 1, 0},
      wire::Welcome{1, 2, 2, 2, 1, 1},     wire::Welcome{1, 1, 2, 0, 1, 1}, wire::Welcome{1, 1, 2, 3, 1, 1},
      wire::Welcome{1, 1, 65, 2, 1, 1},    wire::Redirect{1, Endpoint{}},   wire::Ping{wire::kMaxClock + 1},
      wire::Pong{0, -wire::kMaxClock - 1},
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
