// What a member says of another is believed only with evidence, and a lie that can be proven costs the liar its place.
#include <memory>
#include <set>

#include "common/paths/relay.h"
#include "common/trace/trace_reader.h"
#include "tests/hostile/liar.h"
#include "tests/trace/recorded_lives.h"
#include "tools/lab/replay.h"

namespace padr::test {
namespace {

/// The same datagram as often as the liar sends a state datagram, to each.
wire::Bytes message(PeerId from, const wire::Header& h, const wire::MembershipMessage& m) {
  return wire::seal({wire::Kind::kMembership, from, h.session}, wire::encode_membership(m));
}

/// The liar, which coordinates, has everybody asked about an honest peer that is well, and declares it gone.
void throw_out(Trial& t, PeerId victim) {
  t.liar().send_too([&t, victim](const wire::Header& h, PeerId) {
    return std::vector<wire::Bytes>{message(0, h, wire::Poll{{{victim, t.incarnation(victim), 0}}, true, 0})};
  });
  const auto removal = [&t, victim](sync::Bundle& order) {
    order.removals = {{victim, t.incarnation(victim), t.replica(victim).agreed().log().have(victim)}};
  };
  t.liar().begin(in_place_of_the_next(removal, 600));
}

// Once, members froze whomever the coordinator asked about, and the order that followed was lawful.
TEST(Evidence, TheCoordinatorCannotHaveAPeerThrownOutThatOthersHear) {
  for (const bool plays : {true, false}) {
    Trial t(4, 0, wire::SealMode::kAuth, 601);
    if (plays) t.party().net().attract(Vec2{10, 7});
    throw_out(t, 2);
    t.party().run(8);
    EXPECT_TRUE(t.replica(1).seat(2).there()) << t.party().story();
    EXPECT_TRUE(t.replica(3).seat(2).there()) << t.party().story();
    t.party().net().attract(Vec2{5, 5});  // so that the liar has something to say, and says it as an order
    t.party().run(16);
    EXPECT_GT(t.dropped(1, sync::DropReason::kRight), 0U) << t.party().story();
    EXPECT_TRUE(t.liar_is_out()) << t.party().story();
    t.expect_no_harm();
  }
}

// Once, members took its word for it after 290 s.
TEST(Evidence, TheCoordinatorCannotHaveAPeerThrownOutByNotHearingItForMinutes) {
  Trial t(4, 0, wire::SealMode::kAuth, 601);
  t.liar().send_too([&t](const wire::Header& h, PeerId) {
    return std::vector<wire::Bytes>{message(0, h, wire::Fetch{2, t.incarnation(2), 1'000'000})};
  });
  t.party().run(node::Relay::kUnheardForLong / kTicksPerSecond + 5);
  throw_out(t, 2);
  t.party().run(8);
  EXPECT_TRUE(t.replica(1).seat(2).there()) << t.party().story();
  EXPECT_TRUE(t.replica(3).seat(2).there()) << t.party().story();
  t.liar().stop();
  t.party().run(4);
  t.expect_no_harm();
}

/// It tells one member other things than the rest.
void tell_differently(Trial& t, PeerId victim) {
  t.liar().begin([victim](sync::StatePacket& p, PeerId to) {
    for (sync::Bundle& b : p.updates)
      if (b.avatar && to == victim) b.avatar->position.x += 0.5F;
  });
  t.party().net().attract(Vec2{10, 7});
}

// Once, a ban was the memory of the one peer that had found the lie.
TEST(Evidence, WhoSignsTwoDifferentThingsLosesItsPlaceForGoodWhoeverLeaves) {
  Trial t(5, 2, wire::SealMode::kAuth, 602);
  tell_differently(t, 1);
  t.party().run(8);
  EXPECT_TRUE(t.liar_is_out()) << t.party().story();
  for (const PeerId p : {PeerId{0}, PeerId{3}, PeerId{4}})
    EXPECT_TRUE(t.party().noted(t.person(p), "has signed two different updates of one number: cut off"))
        << p << "\n"
        << t.party().story();
  const int late = t.party().net().start(t.person(3));
  t.party().run(3);
  t.party().net().kill(t.person(0));
  t.party().net().leave(t.person(3));
  t.party().run(12);
  t.party().net().kill(t.person(4));
  t.party().run(12);
  EXPECT_TRUE(t.party().net().peer(late).playing());
  const node::Replica& last = t.party().replica(late);
  int there = 0;
  for (PeerId p = 0; p < last.config().slots; ++p) there += p != last.self() && last.seat(p).there() ? 1 : 0;
  EXPECT_EQ(there, 1) << "the one that was lied to has come back, the liar has not\n" << t.party().story();
}

// A mark is not signed, so nobody else can be shown the lie: those that were misled begin anew themselves, even the
// coordinator, and whoever coordinates after it.
TEST(Evidence, WhoIsPromisedThatThereIsNoMoreFindsOutAndBeginsAnew) {
  for (const std::set<PeerId>& victims : {std::set<PeerId>{0}, {1}, {0, 1}}) {
    Trial t(4, 2, wire::SealMode::kAuth, 603);
    t.party().net().attract(Vec2{10, 7});
    t.liar().begin([&victims, from = std::optional<std::uint32_t>{}](sync::StatePacket& p, PeerId to) mutable {
      if (!victims.contains(to)) return;
      if (!from) from = p.mark_count;
      std::erase_if(p.updates, [&](const sync::Bundle& b) { return b.index >= *from; });
      p.mark_count = std::min(p.mark_count, *from);
    });
    t.party().run(6);
    t.liar().stop();
    t.party().run(14);
    for (const PeerId p : t.honest()) {
      const node::Participant& peer = t.party().net().peer(t.person(p));
      EXPECT_TRUE(peer.playing() && !peer.returning()) << p << "\n" << t.party().story();
      EXPECT_EQ(peer.incarnation() > 0, victims.contains(p)) << p << "\n" << t.party().story();
    }
    for (const PeerId p : victims)
      EXPECT_TRUE(t.party().noted(t.person(p), "kept an update from this peer that it has told others"))
          << t.party().story();
  }
}

// Once, the order that it had promised not to give was only dropped. All waited for 12 s, and whom it had let in by
// that order for as long again.
TEST(Evidence, ACoordinatorThatSaysThatAllIsToldAndThenTellsMoreIsOutAtOnce) {
  Trial t(5, 0, wire::SealMode::kAuth, 607);
  t.liar().begin([](sync::StatePacket& p, PeerId) { p.mark_tick += 100; });
  t.party().net().attract(Vec2{10, 7});
  for (const PeerId p : {PeerId{1}, PeerId{2}, PeerId{3}, PeerId{4}})
    EXPECT_TRUE(t.party().run_until(4, [&] { return t.dropped(p, sync::DropReason::kPromise) > 0; }))
        << p << "\n"
        << t.party().story();
  EXPECT_TRUE(t.party().run_until(6, [&] { return t.liar_is_out(); })) << t.party().story();
  EXPECT_TRUE(t.noted("it had promised that there are no more: ignored for 60 s")) << t.party().story();
  t.party().run(2);
  t.expect_no_harm();
}

// Once, the peer took it, counted its updates from anew, and so signed two of one number: a proof, which the liar could
// show to all.
TEST(Evidence, NobodyTakesAnIncarnationThatItHasHad) {
  Trial t(4, 0, wire::SealMode::kAuth, 608);
  t.party().net().attract(Vec2{10, 7});
  t.party().run(2);
  const std::uint32_t had = t.incarnation(1);
  int welcomed = 0;
  t.liar().speak_to_joiners([&](wire::SessionMessage& m) {
    auto* welcome = std::get_if<wire::Welcome>(&m);
    if (welcome == nullptr || welcomed >= 3) return;
    ++welcomed;
    welcome->peer = 1;
    welcome->incarnation = had;
  });
  t.liar().begin([had](sync::StatePacket& p, PeerId to) {
    if (to == 1) p.to_incarnation = had;
    for (sync::Bundle& b : p.updates)
      if (b.admission && b.admission->slot == 1 && to == 1) {
        b.admission->incarnation = had;
        b.admission->first = 0;
      }
  });
  t.party().net().pause(t.person(1), true);
  t.party().run(5);
  t.party().net().pause(t.person(1), false);
  t.party().run(12);
  EXPECT_GT(welcomed, 0) << t.party().story();
  t.liar().stop();
  t.party().run(12);
  const node::Participant& peer = t.party().net().peer(t.person(1));
  EXPECT_TRUE(peer.playing() && !peer.returning()) << t.party().story();
  EXPECT_EQ(peer.incarnation(), 1) << t.party().story();
  EXPECT_NE(peer.replica().config().incarnation, had) << t.party().story();
  EXPECT_FALSE(t.noted("peer 1 has signed two different updates")) << t.party().story();
  t.expect_confirmed({1, 2, 3});
}

/// The liar keeps its updates back from these, promises that there are none, and then shows them all one at once.
void mislead(Trial& t, const std::set<PeerId>& victims) {
  const auto kept = std::make_shared<std::optional<sync::Bundle>>();
  t.liar().begin([victims, kept](sync::StatePacket& p, PeerId to) {
    if (!*kept && !p.updates.empty() && victims.contains(to)) *kept = p.updates.back();
    if (!*kept || !victims.contains(to)) return;
    std::erase_if(p.updates, [&](const sync::Bundle& b) { return b.index >= (*kept)->index; });
    p.mark_count = std::min(p.mark_count, (*kept)->index);
  });
  t.party().net().attract(Vec2{10, 7});
  t.party().run(0.4);
  t.liar().send_too([&t, victims, kept](const wire::Header& h, PeerId to) {
    std::vector<wire::Bytes> out;
    if (victims.contains(to)) out.push_back(message(2, h, wire::Fetched{2, t.incarnation(2), {**kept}}));
    return out;
  });
  const auto knows = [&t](PeerId p) { return t.party().noted(t.person(p), "kept back an update"); };
  EXPECT_TRUE(t.party().run_until(1, [&] { return std::all_of(victims.begin(), victims.end(), knows); }))
      << t.party().story();
  t.liar().stop();
}

// Once, each asked the first of those that stood down for 6 s more. If the one that stayed ended then, nobody was in.
TEST(Evidence, ThoseWhoAreMisledAskTheOneThatStaysAtOnce) {
  const std::set<PeerId> victims{0, 1, 3};
  Trial t(5, 2, wire::SealMode::kAuth, 607);
  mislead(t, victims);
  t.party().run(1.4);
  for (const PeerId p : victims) {
    const node::Participant& peer = t.party().net().peer(t.person(p));
    EXPECT_TRUE(peer.incarnation() > 0 && !peer.returning()) << p << "\n" << t.party().story();
  }
}

// The last one lets the others in. Once, it stood down as soon as it had given its orders for that, though those whom
// it let in had given up just before; then nobody was in.
TEST(Evidence, TheLastOfThoseWhoAreMisledStaysUntilAnotherOneIsThere) {
  Trial t(5, 2, wire::SealMode::kAuth, 608);
  mislead(t, {0, 1, 3, 4});
  EXPECT_TRUE(t.party().run_until(20, [&] {
    const auto all = t.honest();
    return std::all_of(all.begin(), all.end(), [&](PeerId p) {
      const node::Participant& peer = t.party().net().peer(t.person(p));
      return peer.incarnation() > 0 && !peer.returning();
    });
  })) << t.party().story();
}

// Nobody of those who have left can let the others in, and who could has ended. Once, all were out for good.
TEST(Evidence, WhoHaveAllLeftToJoinAnewFoundTheSessionAnew) {
  Traces traces;
  Trial t(5, 2, wire::SealMode::kAuth, 610, [&traces](lab::VirtualNetworkConfig& c) {
    trace::Provenance from;
    from.scenario = "arena";
    from.scenario_text = scenarios::with_bodies(scenarios::embedded_text("arena"), "arena", 20);
    from.scenario_seed = c.seed;
    c.recording = record_into(traces, from);
  });
  lab::VirtualNetwork& net = t.party().net();
  mislead(t, {0, 1, 3});
  const std::vector<PeerId> left{0, 1, 3};
  const auto all = [&](auto&& is) { return std::all_of(left.begin(), left.end(), is); };
  ASSERT_TRUE(t.party().run_until(20, [&] { return all([&](PeerId p) { return t.replica(p).roster().leaving; }); }))
      << t.party().story();
  net.kill(t.person(4));
  EXPECT_TRUE(t.party().run_until(30, [&] {
    return all([&](PeerId p) {
      const node::Participant& peer = net.peer(t.person(p));
      return peer.incarnation() > 0 && !peer.returning() && peer.session().present() == 3;
    });
  })) << t.party().story();
  t.party().run(5);
  for (const PeerId p : left) {
    const node::ReplicaStats& stats = net.peer(t.person(p)).replica().stats();
    EXPECT_GT(stats.hash_checks, 0U);
    EXPECT_EQ(stats.hash_mismatches, 0U);
  }
  const sync::FoldState& now = net.peer(t.person(0)).replica().agreed().confirmed();
  EXPECT_TRUE(now.playing());
  EXPECT_EQ(std::count_if(now.avatars.begin(), now.avatars.end(), [](const auto& m) { return m.present; }), 3);
  net.finish();
  for (const PeerId p : left) {
    trace::TraceReader reader(traces.at({t.person(p), 1}), "trace");
    const lab::ReplayResult again = lab::replay(reader);
    EXPECT_EQ(again.difference, "");
    EXPECT_GT(again.datagrams_out, 0U);
  }
}

// Whoever has left to join anew is no member any more. Once, it knew nobody if all who had been there joined anew
// before it could.
TEST(Evidence, WhoStandsDownFindsThoseWhoHaveJoinedAnewSince) {
  Trial t(4, 2, wire::SealMode::kAuth, 609);
  lab::VirtualNetwork& net = t.party().net();
  mislead(t, {0});
  net.divide({{t.person(0), 1}});
  for (const PeerId p : {PeerId{1}, PeerId{3}}) {
    net.pause(t.person(p), true);
    t.party().run(12);
    net.pause(t.person(p), false);
    EXPECT_TRUE(t.party().run_until(15, [&] { return net.peer(t.person(p)).incarnation() > 0; })) << t.party().story();
  }
  net.divide({});
  t.party().run(15);
  EXPECT_TRUE(t.party().united()) << t.party().story();
}

// Once, it counted as one that had left, and everybody waited for ever for the update that nobody had taken.
TEST(Evidence, WhoLeavesBehindAnOrderThatNobodyTakesIsRemoved) {
  Trial t(4, 2, wire::SealMode::kAuth, 606);
  t.liar().begin([&t, index = std::optional<std::uint32_t>{}](sync::StatePacket& p, PeerId) mutable {
    for (sync::Bundle& b : p.updates) {
      if (!index && !b.leave) index = b.index;
      if (b.index != index || b.leave) continue;
      sync::Bundle order;
      order.peer = b.peer;
      order.index = b.index;
      order.tick = b.tick;
      order.removals = {{0, t.incarnation(0), 5}};
      b = order;
    }
  });
  t.party().net().attract(Vec2{10, 7});
  t.party().run(1);
  EXPECT_GT(t.dropped(0, sync::DropReason::kRight), 0U) << t.party().story();
  t.party().net().leave(t.person(2));
  t.party().run(14);
  EXPECT_TRUE(t.liar_is_out()) << t.party().story();
  t.expect_no_harm_to({0, 1, 3});
}

// The coordinator gives whoever joins a world that is well formed and wrong.
TEST(Evidence, AFalseWorldHarmsOnlyTheNewcomer) {
  Trial t(4, 0, wire::SealMode::kAuth, 604);
  constexpr std::size_t kInTheFirstEntity = 10;
  t.liar().speak_of_others([](wire::MembershipMessage& m) {
    if (auto* piece = std::get_if<wire::Piece>(&m); piece != nullptr && piece->index == 0)
      piece->bytes[kInTheFirstEntity] ^= std::byte{1};
  });
  const int late = t.party().net().start(t.person(1));
  t.party().run(20);
  EXPECT_GT(t.liar().told, 0U);
  EXPECT_GT(t.party().net().peer(late).incarnation(), 0) << t.party().story();
  for (const PeerId p : t.honest())
    EXPECT_EQ(t.party().net().peer(t.person(p)).incarnation(), 0) << p << "\n" << t.party().story();
  t.party().net().kill(t.person(0));
  EXPECT_TRUE(t.party().run_until(20, [&] { return t.party().united(); }).has_value()) << t.party().story();
  for (const PeerId p : {PeerId{1}, PeerId{2}, PeerId{3}})
    EXPECT_EQ(t.party().net().peer(t.person(p)).incarnation(), 0);
}

}  // namespace
}  // namespace padr::test
