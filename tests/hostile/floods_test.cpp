// A member that sends more than anybody can keep.
#include "tests/hostile/liar.h"

namespace padr::test {
namespace {

using sync::DropReason;

/// What a person keeps of all that others say.
std::size_t kept(const node::Replica& n) {
  std::size_t sum = n.kept().log_ticks + n.kept().pending_checks;
  for (PeerId p = 0; p < n.config().slots; ++p) sum += n.agreed().log().beyond(p);
  return sum;
}

// Numbered ever higher, beyond a first one that never comes, and promised to be complete all the same.
TEST(Floods, AMillionUpdates) {
  for (const auto mode : {wire::SealMode::kNone, wire::SealMode::kAuth}) {
    Trial t(3, 2, mode, 301);
    std::uint64_t sent = 0;
    std::uint32_t next = 1000;
    std::uint32_t seq = 1'000'000;
    std::size_t most = 0;
    t.liar().send_too([&](const wire::Header& h, PeerId) {
      std::vector<wire::Bytes> out;
      const Tick now = t.replica(0).now();
      for (int d = 0; d < 100; ++d) {
        sync::StatePacket p;
        p.seq = ++seq;
        p.mark_tick = now + 100;
        p.mark_count = next + 16;
        for (int i = 0; i < 16; ++i) {
          sync::Bundle b = avatar_update(2, next++, now + 60 + i);
          if (mode != wire::SealMode::kNone && i == 0)
            b.signature = wire::sign_update(t.liar().key(), {t.session(), 0}, b);
          if (mode != wire::SealMode::kNone && i > 0) break;
          p.updates.push_back(b);
          ++sent;
        }
        out.push_back(wire::seal(h, wire::encode(p)));
      }
      return out;
    });
    const std::uint64_t enough = mode == wire::SealMode::kNone ? 1'000'000 : 20'000;
    for (int i = 0; i < 10'000 && sent < enough; ++i) {
      t.party().run(0.02);
      most = std::max(most, kept(t.replica(0)));
    }
    EXPECT_GE(sent, enough);
    EXPECT_LT(most, 3000U) << "it is remembered";
    t.liar().stop();
    t.party().run(12);
    t.expect_confirmed({0, 1});
  }
}

// Promises that are not kept hold everybody's confirmed world up, but not for long.
TEST(Floods, WhoNeverTellsWhatItPromisedIsDeclaredGone) {
  Trial t(4, 1, wire::SealMode::kAuth, 302);
  t.liar().begin([](sync::StatePacket& p, PeerId) {
    p.updates.clear();
    p.mark_count += 5;
  });
  t.party().run(6);
  EXPECT_GT(t.lag(0), 180) << "it is waited for";
  t.party().run(8);
  EXPECT_TRUE(t.liar_is_out()) << t.party().story();
  t.expect_no_harm();
}

// What is not acknowledged is kept, but not for ever: for 16 s. If the first to notice asks before the last has, it
// asks again after 3 s.
TEST(Floods, WhoAcknowledgesNothingIsDeclaredGone) {
  Trial t(4, 2, wire::SealMode::kAuth, 304);
  t.liar().begin([](sync::StatePacket& p, PeerId) { p.have = p.have_beyond = 0; });
  t.party().run(20);
  EXPECT_TRUE(t.liar_is_out()) << t.party().story();
  EXPECT_LT(t.replica(0).kept().own_updates, 16U * 60U);
  t.expect_no_harm();
}

// Whoever tells no hash does not say what it has confirmed. Once, others kept all updates for it, for as long as it was
// there.
TEST(Floods, WhoTellsNoHashIsKeptUpdatesForOnlySoLong) {
  for (const auto mode : {wire::SealMode::kNone, wire::SealMode::kAuth}) {
    Trial t(3, 2, mode, 306);
    t.liar().begin([](sync::StatePacket& p, PeerId) { p.check_tick = -1; });
    t.party().run(70);
    const std::size_t early = t.replica(0).kept().log_ticks;
    EXPECT_GT(early, 15U * 30U) << "or nothing has been tested";
    t.party().run(140);
    EXPECT_LT(t.replica(0).kept().log_ticks, early + early / 2);
    EXPECT_TRUE(t.replica(0).seat(2).there()) << "it need not compute any";
    t.expect_no_harm();
  }
}

// Asked what it has of a lost peer, it says: far more than there is, which nobody can ever send. Once, that kept the
// lost one in, and everybody's confirmed world where it was, for ever.
TEST(Floods, WhoClaimsToHaveMoreOfALostPeerThanItCanShow) {
  for (const auto mode : {wire::SealMode::kNone, wire::SealMode::kAuth}) {
    Trial t(4, 2, mode, 304);
    const PeerId lost = 3;
    t.liar().speak_of_others([](wire::MembershipMessage& m) {
      if (auto* answer = std::get_if<wire::Answer>(&m))
        for (wire::Seat& s : answer->lost) s.have = 1'000'000;
    });
    t.party().net().kill(t.person(lost));
    t.party().run(11);
    EXPECT_GT(t.liar().told, 0U);
    EXPECT_FALSE(t.replica(0).seat(lost).reachable()) << t.party().story();
    t.expect_no_harm_to({0, 1});
  }
}

// Or it says nothing, and is heard all the same.
TEST(Floods, WhoIsAskedWhatItHasOfALostPeerAndNeverAnswers) {
  for (const auto mode : {wire::SealMode::kNone, wire::SealMode::kAuth}) {
    Trial t(4, 2, mode, 305);
    const PeerId lost = 3;
    t.liar().speak_of_others([&t](wire::MembershipMessage& m) {
      if (std::holds_alternative<wire::Answer>(m)) m = wire::Answer{{{1, t.incarnation(1), 0}}};
    });
    t.party().net().kill(t.person(lost));
    t.party().run(11);
    EXPECT_GT(t.liar().told, 0U);
    EXPECT_FALSE(t.replica(0).seat(lost).reachable()) << t.party().story();
    t.expect_no_harm_to({0, 1});
  }
}

// It says that it hears a peer that is gone. Nobody can sign that one's updates, so it is not believed for long.
TEST(Floods, WhoSaysForEverThatItHearsALostPeer) {
  for (const auto mode : {wire::SealMode::kNone, wire::SealMode::kAuth}) {
    Trial t(4, 2, mode, 306);
    const PeerId lost = 3;
    t.liar().speak_of_others([](wire::MembershipMessage& m) {
      if (auto* answer = std::get_if<wire::Answer>(&m))
        for (wire::Seat& s : answer->lost) s.heard = 1;
    });
    t.party().net().kill(t.person(lost));
    t.party().run(5);
    EXPECT_TRUE(t.replica(0).seat(lost).reachable()) << "it is believed for a while";
    t.party().run(4.5);
    EXPECT_GT(t.liar().told, 0U);
    EXPECT_FALSE(t.replica(0).seat(lost).reachable()) << t.party().story();
    t.expect_no_harm_to({0, 1});
  }
}

// What others relay of a peer is its own words or nothing.
TEST(Floods, WhoRelaysWhatAnotherHasNotSaid) {
  Trial t(4, 2, wire::SealMode::kAuth, 307);
  t.liar().speak_of_others([](wire::MembershipMessage& m) {
    if (auto* fetched = std::get_if<wire::Fetched>(&m))
      for (sync::Bundle& b : fetched->updates) b.avatar = avatar_at({3, 3});
  });
  t.party().net().cut(t.person(1), t.person(3), true);
  t.party().net().cut(t.person(3), t.person(1), true);
  t.party().run(20);
  EXPECT_GT(t.liar().told, 0U);
  t.expect_no_harm_to({0, 1, 3});
}

// Updates beyond a missing one, of higher numbers and earlier ticks. Once, whoever was asked for them aborted.
TEST(Floods, WhoAsksForItsOwnUpdatesThatContradictOneAnother) {
  Trial t(4, 2, wire::SealMode::kAuth, 308);
  std::uint32_t ahead = 1000;
  t.liar().begin([&](sync::StatePacket& p, PeerId) {
    const std::uint32_t index = p.mark_count + --ahead;
    p.updates = {avatar_update(2, index, ++p.mark_tick)};
    p.mark_count = index + 1;
  });
  t.liar().send_too([&t](const wire::Header& h, PeerId) {
    return std::vector<wire::Bytes>{wire::seal({wire::Kind::kMembership, h.sender, h.session},
                                               wire::encode_membership(wire::Fetch{2, t.incarnation(2), 0}))};
  });
  EXPECT_TRUE(t.party().run_until(1, [&] { return t.replica(0).agreed().log().beyond(2) > 0; })) << t.party().story();
  t.party().run(10);
  t.expect_no_harm();
}

// Polls, fetches, answers, probes and joins by the thousand.
TEST(Floods, MessagesOfMembership) {
  for (const auto mode : {wire::SealMode::kNone, wire::SealMode::kAuth}) {
    Trial t(4, 2, mode, 303);
    std::uint64_t sent = 0;
    std::uint64_t nonce = 1;
    t.liar().send_too([&](const wire::Header& h, PeerId) {
      std::vector<wire::Bytes> out;
      const auto membership = [&](const wire::MembershipMessage& m) {
        out.push_back(wire::seal({wire::Kind::kMembership, h.sender, h.session}, wire::encode_membership(m)));
      };
      const std::uint32_t first = t.incarnation(1);
      wire::Fetched fetched{1, first, {}};
      for (std::uint32_t i = 0; i < 10; ++i)
        fetched.updates.push_back(
            avatar_update(1, 5000 + 10 * static_cast<std::uint32_t>(nonce) + i, 600 + static_cast<Tick>(i)));
      for (int i = 0; i < 20; ++i) {
        membership(wire::Poll{{{1, first, 0}, {3, t.incarnation(3), 0}}});
        membership(wire::Answer{{{0, 0, 1'000'000}, {1, first, 1'000'000}}});
        membership(wire::Fetch{1, first, 0});
        membership(fetched);
        membership(wire::Probe{
            0, {{2, t.incarnation(2), 0}, {5, 9, 0}, {6, 9, 0}, {7, 9, 0}, {8, 9, 0}, {9, 9, 0}}, false, 100});
        membership(wire::Pull{++nonce, 0, ~std::uint64_t{0}, nonce});
        membership(wire::Enter{nonce});
        const wire::Join join{nonce, 0, 0, true, "x"};
        out.push_back(wire::seal({wire::Kind::kSession, kNoPeer, h.session}, wire::encode_session(join)));
      }
      sent += out.size();
      return out;
    });
    t.party().run(8);
    EXPECT_GT(sent, 10'000U);
    EXPECT_FALSE(t.replica(0).seat(1).frozen) << "asked by who is not the coordinator";
    t.liar().stop();
    t.party().run(8);
    if (mode == wire::SealMode::kNone)
      t.expect_confirmed({0, 1, 3});  // anybody may say anything in anybody's name
    else
      t.expect_no_harm();
  }
}

}  // namespace
}  // namespace padr::test
