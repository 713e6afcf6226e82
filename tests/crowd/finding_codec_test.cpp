// Ask and Tell on the wire.
#include <gtest/gtest.h>

#include "common/wire/session_codec.h"

namespace padr::wire {
namespace {

Ask ask() {
  return {7, 99, 12, {{1, 2}, {3}}, 5};
}

Tell tell() {
  Tell t{7, 99, 12, {{1, 2}, {3}}, 5};
  t.clock = 1'000'000;
  t.known = {{ipv4({10, 0, 0, 1}, 7000), {{4}, {}}}, {ipv4({10, 0, 0, 2}, 7000), {{}, {5, 6}}}};
  t.noted = true;
  return t;
}

TEST(FindingCodec, ComesOutAsItWentIn) {
  EXPECT_EQ(decode_session(encode_session(ask())), SessionMessage(ask()));
  EXPECT_EQ(decode_session(encode_session(tell())), SessionMessage(tell()));
}

TEST(FindingCodec, AnAskIsAsLargeWhateverItSays) {
  EXPECT_EQ(encode_session(ask()).size(), kAskPayload);
  Ask most = ask();
  most.crowd = ~0ULL;
  most.rank = ~0U;
  most.sender.in.assign(kMostRegions, ~0U);
  most.sender.seeks.assign(kMostRegions, ~0U);
  EXPECT_EQ(encode_session(most).size(), kAskPayload);
}

template <typename Change>
bool reads(Change change) {
  Tell t = tell();
  change(t);
  return decode_session(encode_session(t)).has_value();
}

TEST(FindingCodec, WhatIsOutOfRangeIsMalformed) {
  EXPECT_TRUE(reads([](Tell&) {}));
  EXPECT_FALSE(reads([](Tell& t) { t.nonce = 0; }));
  EXPECT_FALSE(reads([](Tell& t) { t.about = 0; }));
  EXPECT_TRUE(reads([](Tell& t) { t.clock = kMaxClock; }));
  EXPECT_FALSE(reads([](Tell& t) { t.clock = kMaxClock + 1; }));
  EXPECT_FALSE(reads([](Tell& t) { t.clock = -1; }));
  EXPECT_TRUE(reads([](Tell& t) { t.sender.in.assign(kMostRegions, 1); }));
  EXPECT_FALSE(reads([](Tell& t) { t.sender.in.assign(kMostRegions + 1, 1); }));
  EXPECT_FALSE(reads([](Tell& t) { t.sender.seeks.assign(kMostRegions + 1, 1); }));
  EXPECT_FALSE(reads([](Tell& t) { t.sender.in.push_back(0); }));
  EXPECT_FALSE(reads([](Tell& t) { t.known[0].at.port = 0; }));
  EXPECT_FALSE(reads([](Tell& t) { t.known[1].where.seeks.push_back(0); }));
  EXPECT_TRUE(reads([](Tell& t) { t.known.resize(kMostKnown, t.known[0]); }));
  EXPECT_FALSE(reads([](Tell& t) { t.known.resize(kMostKnown + 1, t.known[0]); }));
}

}  // namespace
}  // namespace padr::wire
