#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/membership/membership.h"
#include "common/model/endpoint.h"
#include "common/model/ids.h"
#include "common/participant/session_joiner.h"
#include "common/participant/transfer_pull.h"
#include "common/session/session_clock.h"
#include "common/session/session_state.h"

namespace padr::node {

/// Datagrams that arrived for a session, by outcome.
struct SessionStats {
  std::uint64_t datagrams = 0;
  std::uint64_t state = 0;      ///< for the replica
  std::uint64_t session = 0;    ///< understood here
  std::uint64_t seal = 0;       ///< too short or long, wrong magic, kind or tag
  std::uint64_t version = 0;    ///< of another protocol version
  std::uint64_t foreign = 0;    ///< another session, or not from the member it claims to be from
  std::uint64_t malformed = 0;  ///< does not decode
};

/// A peer's entry into a session: it founds one, or joins through any member, synchronises its clock and gets the
/// agreed world. From then on it has the session's time.
///
/// Pure: local time is microseconds on any monotonic clock of the caller's, the same for all calls. Everything is
/// repeated until answered, at a bounded rate, so any loss below 100 % only costs time. What others send is never
/// trusted further than its values' ranges: see SessionStats.
class Session {
 public:
  Session(const SessionConfig& config, Micros local);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Takes a datagram. Returns true if it is a state datagram of this session from the member that it claims to be
  /// from: the replica has to read it.
  bool receive(const Endpoint& from, const wire::Opened& opened, Micros local);
  /// A datagram has arrived that wire::open refused.
  void on_refused(const Endpoint& from, std::size_t bytes, wire::SealError why, std::uint8_t version, Micros local);
  /// The machine at `at` reports that nobody listens there.
  void unreachable(const Endpoint& at, Micros local);
  /// Does what is due; call at least whenever next_due() has come.
  void advance(Micros local);
  Micros next_due() const { return next_due_; }

  /// What to send, in order; empty afterwards.
  std::vector<SessionDatagram> take_outgoing();
  /// Events to report; empty afterwards.
  std::vector<SessionEvent> take_events();

  SessionPhase phase() const { return session_.phase; }
  /// Why the phase is kFailed, or why this peer gave up waiting for members; empty otherwise.
  const std::string& failure() const { return session_.failure; }
  /// Whether it failed because our introducer was lost: see TransferPull::lost.
  bool lost_introducer() const { return session_.phase == SessionPhase::kFailed && pull_ && pull_->lost(); }
  /// This peer's number; kNoPeer until it is welcomed.
  PeerId self() const { return session_.self; }
  /// Drawn by the founder, never 0; 0 until known.
  std::uint16_t number() const { return session_.number; }
  const SessionId& id() const { return session_.id; }
  int slots() const { return session_.slots; }
  int wanted() const { return session_.wanted; }
  /// Members present, this one included.
  int present() const { return session_.present; }
  int spectators() const { return session_.spectators; }
  /// Members present that have an avatar.
  int players() const { return session_.present - session_.spectators; }
  /// Least round trip to our introducer so far, us; 0 for the founder.
  Micros round_trip() const { return pull_ ? pull_->round_trip() : 0; }
  const SessionStats& stats() const { return stats_; }

  /// While kEntering: the agreed world has come, see transfer(), and the clock runs.
  bool may_enter() const { return pull_ && pull_->ready(); }
  const wire::Bytes& transfer() const { return pull_->transfer(); }
  /// The member that welcomed us, which is to admit us.
  const Endpoint& introducer() const { return pull_->by(); }
  /// Our introducer; not set for the founder.
  Endpoint let_in_by() const { return pull_ ? pull_->by() : Endpoint{}; }
  PeerId introducer_number() const { return introducer_; }
  /// While kEntering: session time is at least this, us.
  void time_is_at_least(Micros session, Micros local) { pull_->clock_is_ahead(session - local); }
  /// Asks to be admitted; call `admitted` once that has happened.
  void enter(Micros local) { pull_->enter(local); }
  void admitted() { session_.phase = SessionPhase::kMember; }
  /// Play has begun: from now on the clock is no longer stepped, only steered.
  void settle_clock() { settled_ = true; }
  /// Whom to ask through whom, if nothing comes directly; nothing unless this peer was redirected lately.
  std::optional<Joiner::Introduction> introduction(Micros local) const {
    return joiner_ ? joiner_->introduction(local) : std::nullopt;
  }
  std::uint32_t incarnation() const { return session_.incarnation; }
  /// Once a member, or entering with may_enter(): `membership` handles the members from now on.
  void hand_over_to(Membership* membership) { membership_ = membership; }
  SessionState& state() { return session_; }

  /// Once a member, or entering with may_enter(): session microseconds.
  Micros session_now(Micros local) const { return session_.clock.now(local); }
  Micros local_at(Micros session) const { return session_.clock.local_at(session); }
  /// Corrects our lead of `lead` us over the peer whose clock counts; see SessionClock.
  void steer(Micros local, Micros lead) { session_.clock.steer(local, lead); }
  /// The clock has stood still for so long: sets it right at once.
  void skip(Micros local, Micros by) { session_.clock.skip(local, by); }
  const SessionClock& clock() const { return session_.clock; }

 private:
  void found(Micros local);
  void dispatch(const Endpoint& from, const wire::Header& header, const wire::SessionMessage& message, Micros local);
  void note_other_session(const Endpoint& from, Micros local);
  void take_membership(const Endpoint& from, const wire::Opened& opened, Micros local);
  void other_version(const Endpoint& from, std::size_t bytes, std::uint8_t version, Micros local);

  SessionState session_;
  std::unique_ptr<Joiner> joiner_;      ///< unless it founds
  std::unique_ptr<TransferPull> pull_;  ///< once welcomed
  PeerId introducer_ = kNoPeer;
  bool settled_ = false;
  std::optional<Micros> others_since_;  ///< while it waits as a founder: when it heard from another session
  Membership* membership_ = nullptr;
  SessionStats stats_;
  Micros next_due_ = 0;
};

}  // namespace padr::node
