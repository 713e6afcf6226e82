#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/membership/last_heard.h"
#include "common/scenarios/scenarios.h"
#include "common/session/commands.h"
#include "common/session/session_state.h"
#include "common/session/view.h"

namespace padr::test {

/// When a Situation is seen.
inline constexpr Tick kNow = 1000;
/// A peer not heard since is silent then.
inline constexpr Tick kLongAgo = kNow - node::kSilence;

/// Commands as a list, for a test to look into.
class ListedCommands final : public node::Commands {
 public:
  template <typename Message>
  struct Sent {
    Endpoint to;
    Message message;
  };

  void send(const Endpoint& to, const wire::SessionMessage& message) override { session_.push_back({to, message}); }
  void send(const Endpoint& to, const wire::MembershipMessage& message) override { sent_.push_back({to, message}); }
  std::size_t send_at_most(std::size_t bytes, const Endpoint& to, const wire::MembershipMessage& message) override {
    const std::size_t size = wire::encode_membership(message).size();
    if (size > bytes) return 0;
    send(to, message);
    return size;
  }
  bool may_answer(Micros /*local*/) override { return answers; }
  void publish(const sync::Bundle& order) override { orders.push_back(order); }
  void freeze(PeerId p, bool frozen) override { freezes.emplace_back(p, frozen); }
  void give_up(PeerId p, bool /*for_good*/) override { given_up.push_back(p); }
  void cut_off(PeerId p, const std::string& /*why*/) override { cut_offs.push_back(p); }
  void relay(const wire::Fetched& updates, PeerId) override { relayed.push_back(updates); }
  void count_present(int /*members*/, int /*spectators*/) override {}
  void tell(node::SessionEvent event) override { events.push_back(std::move(event)); }

  /// All messages of that kind that were sent.
  template <typename Message>
  std::vector<Sent<Message>> all() const {
    std::vector<Sent<Message>> found;
    const auto look_into = [&found](const auto& list) {
      for (const auto& s : list)
        std::visit(
            [&](const auto& m) {
              if constexpr (std::is_same_v<std::decay_t<decltype(m)>, Message>) found.push_back({s.to, m});
            },
            s.message);
    };
    look_into(sent_);
    look_into(session_);
    return found;
  }
  bool told(node::SessionEvent::Kind kind) const {
    return std::any_of(events.begin(), events.end(), [kind](const auto& e) { return e.kind == kind; });
  }

  bool answers = true;
  std::vector<sync::Bundle> orders;
  std::vector<std::pair<PeerId, bool>> freezes;
  std::vector<PeerId> cut_offs;
  std::vector<PeerId> given_up;
  std::vector<wire::Fetched> relayed;
  std::vector<node::SessionEvent> events;

 private:
  std::vector<Sent<wire::SessionMessage>> session_;
  std::vector<Sent<wire::MembershipMessage>> sent_;
};

/// A session as values, seen by the member in slot `self` at kNow: all slots are taken, all have just been heard,
/// and nobody has anything more to tell.
struct Situation {
  explicit Situation(int slots, PeerId self) : log(slots) {
    session.self = self;
    session.slots = slots;
    session.number = 7;
    roster.self = self;
    roster.member = true;
    roster.now = kNow;
    roster.incarnation = 1U + self;
    roster.seats.resize(static_cast<std::size_t>(slots));
    for (PeerId p = 0; p < slots; ++p) {
      log.begin(p, 0, kNow);
      node::Seat& s = roster.seats[p];
      s.at = at(p);
      if (p == self) continue;
      s.presence = node::Presence::kThere;
      s.incarnation = 1U + p;
      s.heard = s.answered = s.answer_mark = kNow;
      s.proven = true;
    }
  }
  static Endpoint at(int p) { return ipv4({10, 0, 0, static_cast<std::uint8_t>(1 + p)}, 7000); }
  node::View view() const { return {roster, log, scene, returning}; }
  /// p has neither been heard nor answered since that tick.
  void silence(PeerId p, Tick since) {
    node::Seat& s = roster.seats[p];
    s.heard = s.answered = s.answer_mark = since;
  }
  /// Nobody sits in p's slot any more, and all is known of who did.
  void empty(PeerId p) {
    roster.seats[p].presence = node::Presence::kAbsent;
    log.close(p, log.have(p));
  }
  /// p's update of that number has come.
  sync::Bundle tells(PeerId p, std::uint32_t index, Tick tick) {
    sync::Bundle b;
    b.peer = p;
    b.index = index;
    b.tick = tick;
    log.insert(b);
    return b;
  }
  /// What a Replica does with these commands, as far as rules see it. The next tick begins.
  void follow(const ListedCommands& commands) {
    for (const auto& [p, frozen] : commands.freezes) roster.seats[p].frozen = frozen;
    for (const PeerId p : commands.given_up) roster.give_up(p, false);
    ++roster.now;
  }
  wire::Seat named(PeerId p) const { return {p, roster.seats[p].incarnation, 0, 0}; }

  Scene scene = scenarios::load_embedded("arena", 1);
  node::SessionState session;
  node::Roster roster;
  PeerSet returning = 0;
  sync::UpdateLog log;
};

}  // namespace padr::test
