#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/session/session_clock.h"
#include "common/session/session_event.h"
#include "common/wire/membership_codec.h"
#include "common/wire/session_codec.h"

namespace padr::node {

struct SessionConfig {
  std::optional<Endpoint> join;  ///< any member; absent: found a session
  std::vector<Endpoint> others;  ///< members that are asked in turn where that one does not answer
  // Set by the founder:
  int wanted = 2;  ///< avatars that must be present for play to begin, 1 .. slots
  int slots = 2;   ///< avatar slots, wanted .. kMaxPeers
  // The same for all members; a Participant fills them in:
  std::uint64_t scene_hash = 0;
  std::uint64_t fingerprint = 0;  ///< of physics: see world::physics_fingerprint
  bool authority = true;
  bool spectates = false;  ///< this peer has no avatar
  /// For messages to people: "NAME seed N". padr-capture loads a built-in scene by it.
  std::string scenario;
  /// Seed of the session's number, or of the joiner's nonce. No two runs may have the same.
  std::uint64_t seed = 0;
  /// Key of the cookies by which a joiner proves its address. No other peer may know or guess it.
  std::uint64_t secret = 0;
  /// The session's number if it is known beforehand, as in a crowd; 0: drawn by the founder.
  std::uint16_t number = 0;
  /// Founds a region of a crowd, alone and at once; the session time is this (us) now.
  std::optional<Micros> begins_at{};
  bool sealed = false;  ///< the session has a key
  /// Where this peer can be reached, as far as its own machine knows: on its LAN, or by IPv6. Told to members that it
  /// does not reach directly; see is_of_one_host.
  std::vector<Endpoint> own_addresses{};
  SessionId id{};  ///< of a session with a key; a joiner is told it
  /// The session's time is ahead of ours by this at most, us, whatever the introducer says; absent: not known.
  std::optional<Micros> most_offset{};
  /// Joins that may be sent in all, but for one more for each of the first redirects: whoever sends them may have named
  /// the address of somebody else. Absent: any number.
  std::optional<int> joins{};
  bool returns = false;  ///< this peer has been in the session before
  /// Longest time from this peer's start to the begin of play, us; 0: no limit.
  Micros patience = 30 * kMicrosPerSecond;
  /// So much of it an attempt before this one took, in which a member answered, us; 0: there was none.
  Micros waited = 0;
  std::string failed{};  ///< why that one failed
};

enum class SessionPhase : std::uint8_t {
  kJoining,   ///< asks a member for a slot
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
  static constexpr Micros kTick = 10'000;       ///< timers are looked at this often
  static constexpr Micros kJoin = 200'000;      ///< between the first Joins
  static constexpr int kJoins = 4;              ///< of them
  static constexpr Micros kRareJoin = 400'000;  ///< between later ones
  static constexpr Micros kUnheard = 700'000;   ///< after a redirect, until it asks the first address again
  /// After a redirect, until a newcomer that has heard nothing asks through the member that has redirected it, too.
  static constexpr Micros kDirectly = 300'000;
};

/// The session as this peer knows it: all that the membership rules see of it.
struct SessionView {
  SessionConfig config;
  PeerId self = kNoPeer;          ///< until it is welcomed
  std::uint32_t incarnation = 0;  ///< of this peer in its slot
  std::uint16_t number = 0;
  SessionId id{};
  int slots = 0;
  int wanted = 0;
  int present = 0;     ///< members present, this one included
  int spectators = 0;  ///< of them
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
  /// Sends the message only if its datagram has at most `bytes` bytes. Returns the datagram's bytes, 0 if not sent.
  std::size_t send_at_most(std::size_t bytes, const Endpoint& to, const wire::MembershipMessage& message) {
    send(to, message);
    const std::size_t size = outgoing.back().bytes.size();
    if (size <= bytes) return size;
    outgoing.pop_back();
    return 0;
  }
  /// Limits replies to requests: at most kAnswers at once and as many a second, so that we flood no third party.
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
