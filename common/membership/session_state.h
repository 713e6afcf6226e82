#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/membership/session_clock.h"
#include "common/membership/session_event.h"
#include "common/wire/membership_codec.h"
#include "common/wire/session_codec.h"

namespace padr::node {

struct SessionConfig {
  std::optional<Endpoint> join;  ///< any member; absent: found a session
  // The founder's to say:
  int wanted = 2;  ///< members that play waits for, 1 .. slots
  int slots = 2;   ///< avatar slots, wanted .. kMaxPeers
  // What all must have alike; a Participant fills it in:
  std::uint64_t scene_hash = 0;
  std::uint64_t fingerprint = 0;  ///< of physics: see world::physics_fingerprint, which takes some milliseconds once
  bool authority = true;
  std::string scenario;  ///< for messages to people: name and seed
  /// Draws the session's number, or the joiner's nonce. Two runs must not have the same.
  std::uint64_t seed = 0;
  /// Nobody else knows or guesses it: of it are the cookies by which a newcomer proves its address.
  std::uint64_t secret = 0;
  /// Known beforehand, as in a crowd; 0: drawn by the founder.
  std::uint16_t number = 0;
  /// A region of a crowd is founded: alone, at once, and it is this session time (us) now.
  std::optional<Micros> begins_at{};
  bool sealed = false;  ///< it has a key; for messages to people
  /// us from the beginning to the begin of play at most; 0: no limit.
  Micros patience = 30 * kMicrosPerSecond;
};

enum class SessionPhase : std::uint8_t {
  kJoining,   ///< asks to be let in
  kEntering,  ///< gets the agreed world, then is admitted
  kMember,    ///< has founded it, or has been admitted
  kFailed,    ///< see failure()
};

struct SessionDatagram {
  Endpoint to;
  wire::Bytes bytes;
};

/// How often peers repeat themselves, and how long they wait; us.
struct SessionPace {
  static constexpr Micros kTick = 10'000;      ///< timers are looked at this often
  static constexpr Micros kJoin = 200'000;     ///< between two Joins
  static constexpr Micros kUnheard = 700'000;  ///< after being passed on, until asking where it asked first
};

/// What a session is to this peer: all that the rules of membership see of it.
struct SessionView {
  SessionConfig config;
  PeerId self = kNoPeer;          ///< until it is a member
  std::uint32_t incarnation = 0;  ///< of this peer in its slot
  std::uint16_t number = 0;
  int slots = 0;
  int wanted = 0;
  int present = 0;  ///< members that are there, this one included
  SessionClock clock;
};

/// A session in progress, and what it sends.
struct SessionState : SessionView {
  SessionPhase phase = SessionPhase::kJoining;
  std::string failure;
  Micros born = 0;
  std::vector<SessionDatagram> outgoing;
  std::vector<SessionEvent> events;

  void send(const Endpoint& to, const wire::SessionMessage& message) {
    outgoing.push_back({to, wire::seal({wire::Kind::kSession, self, number}, wire::encode_session(message))});
  }
  void send(const Endpoint& to, const wire::MembershipMessage& message) {
    outgoing.push_back({to, wire::seal({wire::Kind::kMembership, self, number}, wire::encode_membership(message))});
  }
  /// Sends it only if the datagram has at most so many bytes; returns its bytes, 0 if it was not sent.
  std::size_t send_at_most(std::size_t bytes, const Endpoint& to, const wire::MembershipMessage& message) {
    send(to, message);
    const std::size_t size = outgoing.back().bytes.size();
    if (size <= bytes) return size;
    outgoing.pop_back();
    return 0;
  }
  /// Answers to anybody who asks: at most kAnswers at once and as many a second, so that nobody is flooded through us.
  bool may_answer(Micros local) {
    answers_ = std::min(kAnswers, answers_ + static_cast<double>(local - answered_) * kAnswers / kMicrosPerSecond);
    answered_ = local;
    if (answers_ < 1) return false;
    answers_ -= 1;
    return true;
  }
  void tell(SessionEvent event) {
    if (events.size() < kEventsKept) events.push_back(std::move(event));
  }
  void fail(std::string text) {
    phase = SessionPhase::kFailed;
    failure = std::move(text);
  }

 private:
  static constexpr double kAnswers = 50;
  static constexpr std::size_t kEventsKept = 64;
  double answers_ = kAnswers;
  Micros answered_ = 0;
};

}  // namespace padr::node
