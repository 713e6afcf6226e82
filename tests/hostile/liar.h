#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/wire/codec.h"
#include "common/wire/membership_codec.h"
#include "common/wire/signature.h"
#include "tests/membership/party.h"
#include "tools/lab/testbed/liar.h"

namespace padr::test {

using lab::Liar;

/// What a peer would say of its avatar there.
inline sync::AvatarUpdate avatar_at(Vec2 position, Vec2 velocity = {}) {
  sync::AvatarUpdate u;
  u.position = position;
  u.velocity = velocity;
  return u;
}

/// An update that says only that.
inline sync::Bundle avatar_update(PeerId whose, std::uint32_t index, Tick tick) {
  sync::Bundle b;
  b.peer = whose;
  b.index = index;
  b.tick = tick;
  b.avatar = avatar_at({3, 3});
  return b;
}

/// A lie: the liar's next update from tick `since` on is an order, as often as it is said.
inline Liar::Lie in_place_of_the_next(std::function<void(sync::Bundle&)> order, Tick since = 0) {
  return
      [order = std::move(order), since, index = std::optional<std::uint32_t>{}](sync::StatePacket& p, PeerId) mutable {
        if (p.mark_tick < since) return;
        if (!index) index = p.mark_count;
        for (sync::Bundle& b : p.updates) {
          if (b.index != *index) continue;
          sync::Bundle lie;
          lie.peer = b.peer;
          lie.index = b.index;
          lie.tick = b.tick;
          order(lie);
          b = lie;
        }
      };
}

/// Peers of whom one lies, on virtual time. All are named by their slots.
class Trial {
 public:
  /// `adapt` may change what the network is built from.
  Trial(int founders, PeerId liar, wire::SealMode seal, std::uint64_t seed,
        const std::function<void(lab::VirtualNetworkConfig&)>& adapt = {})
      : liar_slot_(liar),
        liars_(static_cast<std::size_t>(founders)),
        party_(config(founders, seal, seed, adapt), [this](lab::VirtualNetwork& g) {
          g.on_start = [this](int person, node::ParticipantConfig& c) {
            if (liars_.size() <= static_cast<std::size_t>(person)) liars_.resize(static_cast<std::size_t>(person) + 1);
            if (c.channels) of_person(person).learn_key(*c.channels);
            c.tamper = [this, person](node::Parcel p) { return of_person(person).tamper(std::move(p)); };
          };
        }) {
    EXPECT_TRUE(party_.run_until(10, [&] { return party_.united(); })) << party_.story();
    party_.run(4);
    persons_.resize(liars_.size());
    for (int p = 0; p < founders; ++p) persons_[party_.replica(p).self()] = p;
    of_person(person(liar)).learn_session(session());
    liar_incarnation_ = incarnation(liar);
    party_.judge_too().expect_lies_of(person(liar));
  }

  Liar& liar() { return of_person(person(liar_slot_)); }
  Party& party() { return party_; }
  int person(PeerId slot) const { return persons_[slot]; }
  const node::Replica& replica(PeerId slot) const { return party_.replica(person(slot)); }
  const SessionId& session() const { return replica(honest()[0]).config().session_id; }
  Tick lag(PeerId slot) const { return party_.lag(person(slot)); }
  /// Of who sits there now, as the wire has it.
  std::uint32_t incarnation(PeerId slot) const { return replica(slot).config().incarnation; }
  std::vector<PeerId> honest() const {
    std::vector<PeerId> all;
    for (PeerId p = 0; p < persons_.size(); ++p)
      if (p != liar_slot_ && party_.net().runs(person(p))) all.push_back(p);
    return all;
  }
  /// Datagrams that a peer has dropped for a reason.
  std::uint64_t dropped(PeerId slot, sync::DropReason why) const {
    return replica(slot).stats().dropped[static_cast<std::size_t>(why)];
  }
  bool noted(const std::string& words) const { return party_.story().find(words) != std::string::npos; }
  /// Those of them confirm the same as one another, and now.
  void expect_confirmed(const std::vector<PeerId>& who) {
    const std::uint64_t before = party_.judge().compared();
    const Tick tick = replica(who[0]).agreed().confirmed().tick;
    party_.run(3);
    EXPECT_GT(party_.judge().compared(), before + 60) << party_.story();
    EXPECT_GT(replica(who[0]).agreed().confirmed().tick, tick + 100) << party_.story();
    for (const PeerId p : who) EXPECT_LT(lag(p), 180) << p << "\n" << party_.story();
    EXPECT_EQ(party_.judge().violation(), "") << party_.story();
  }
  /// Nobody honest has come to harm: all play on in the incarnations they had, and confirmed worlds are the same.
  void expect_no_harm() { expect_no_harm_to(honest()); }
  void expect_no_harm_to(const std::vector<PeerId>& who) {
    for (const PeerId p : who) {
      EXPECT_TRUE(party_.net().peer(person(p)).playing()) << p << "\n" << party_.story();
      EXPECT_EQ(party_.net().peer(person(p)).incarnation(), 0) << p << "\n" << party_.story();
    }
    expect_confirmed(who);
  }
  /// The honest have declared the liar gone, as who it was when the trial began; it may have come back since.
  bool liar_was_out() const {
    const auto all = honest();
    return std::none_of(all.begin(), all.end(), [this](PeerId p) {
      const node::Seat& seat = replica(p).seat(liar_slot_);
      return seat.there() && seat.incarnation == liar_incarnation_;
    });
  }
  /// The honest have declared the liar gone, and it is not back.
  bool liar_is_out() const {
    const auto all = honest();
    return std::none_of(all.begin(), all.end(), [this](PeerId p) { return replica(p).seat(liar_slot_).there(); });
  }

 private:
  Liar& of_person(int person) { return liars_[static_cast<std::size_t>(person)]; }
  static lab::VirtualNetworkConfig config(int founders, wire::SealMode seal, std::uint64_t seed,
                                          const std::function<void(lab::VirtualNetworkConfig&)>& adapt) {
    lab::VirtualNetworkConfig c = party_config(founders, "delay 30ms 5ms loss 1%", seed);
    c.seal = seal;
    if (adapt) adapt(c);
    return c;
  }

  PeerId liar_slot_;
  std::vector<Liar> liars_;   ///< by person; only one ever begins
  std::vector<int> persons_;  ///< by slot
  std::uint32_t liar_incarnation_ = 0;
  Party party_;
};

}  // namespace padr::test
