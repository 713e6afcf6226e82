// When a newcomer goes on pulling the agreed world, and when it gives its introducer up.
#include "common/participant/transfer_pull.h"

#include <gtest/gtest.h>

namespace padr::test {
namespace {

using node::TransferPull;

constexpr Micros kRoundTrip = 20'000;

struct Introducer {
  std::string name;
  Micros piece_every;  ///< 0: it sends the first piece only
  bool is_given_up;
};

// Once, an introducer that never sent all kept a peer that joined anew waiting until it forgot it, 11 s later.
TEST(TransferPull, GivesUpAnIntroducerThatSendsNothingMore) {
  for (const Introducer& i :
       {Introducer{"sends one piece only", 0, true}, Introducer{"is on a narrow link", 2'000'000, false}}) {
    node::SessionState session;
    const Endpoint by = ipv4({10, 0, 0, 1}, 7000);
    wire::Welcome welcome;
    welcome.nonce = 5;
    TransferPull pull(session, by, welcome, 0);
    std::uint32_t pieces = 0;
    Micros given_up = 0;
    for (Micros local = node::SessionPace::kTick; local < 10'000'000 && given_up == 0;
         local += node::SessionPace::kTick) {
      pull.on_pong(by, {local - kRoundTrip, local}, local);
      const bool due = i.piece_every == 0 ? pieces == 0 : local / i.piece_every >= pieces;
      if (due) pull.on_piece(by, {welcome.nonce, pieces++, 50, wire::Bytes(10)}, local);
      pull.advance(local);
      if (session.phase == node::SessionPhase::kFailed) given_up = local;
    }
    EXPECT_EQ(given_up > 0, i.is_given_up) << i.name;
    if (i.is_given_up) {
      EXPECT_LT(given_up, TransferPull::kPatience + kMicrosPerSecond);
    }
  }
}

// It answers Pings for ever, but lets nobody in. Once, a peer that joined anew waited by it for ever.
TEST(TransferPull, GivesUpAnIntroducerThatOnlyTellsTheTime) {
  for (const bool sends_all : {false, true}) {
    node::SessionState session;
    const Endpoint by = ipv4({10, 0, 0, 1}, 7000);
    TransferPull pull(session, by, {}, 0);
    Micros local = 0;
    const auto go_on_until = [&](Micros until) {
      for (; local < until && session.phase != node::SessionPhase::kFailed; local += node::SessionPace::kTick) {
        pull.on_pong(by, {std::max<Micros>(0, local - kRoundTrip), local}, local);
        pull.advance(local);
      }
    };
    if (sends_all) pull.on_piece(by, {0, 0, 1, wire::Bytes(10)}, 1);
    go_on_until(kMicrosPerSecond);
    EXPECT_EQ(pull.ready(), sends_all);
    if (sends_all) pull.enter(local);
    go_on_until(TransferPull::kLongest);
    EXPECT_FALSE(pull.lost()) << "there may be a crowd";
    go_on_until(TransferPull::kLongest + kMicrosPerSecond);
    EXPECT_TRUE(pull.lost());
  }
}

// What most others have told of this peer's clock counts more than what an introducer says of its own.
TEST(TransferPull, TakesNoTimeThatIsLaterThanTheOthersProve) {
  for (const Micros most : {Micros{-500'000}, Micros{500'000}}) {
    node::SessionState session;
    session.config.most_offset = most;
    const Endpoint by = ipv4({10, 0, 0, 1}, 7000);
    TransferPull pull(session, by, {}, 0);
    pull.on_piece(by, {0, 0, 1, wire::Bytes(10)}, 1);
    for (Micros local = 100'000; !pull.ready() && local < kMicrosPerSecond; local += 10'000)
      pull.on_pong(by, {local - kRoundTrip, local - kRoundTrip / 2}, local);
    ASSERT_TRUE(pull.ready());
    EXPECT_EQ(session.clock.now(kMicrosPerSecond), kMicrosPerSecond + std::min<Micros>(most, 0));
  }
}

}  // namespace
}  // namespace padr::test
