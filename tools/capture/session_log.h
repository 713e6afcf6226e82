#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/sync/packet.h"
#include "common/wire/membership_codec.h"
#include "common/wire/session_codec.h"
#include "tools/capture/input.h"

namespace padr::capture {

/// Who said something: a slot and which of those who sat there in turn.
struct Incarnation {
  PeerId slot = kNoPeer;
  std::uint32_t incarnation = 0;
  friend auto operator<=>(const Incarnation&, const Incarnation&) = default;
};

/// How people are told of incarnations: by the slot alone if it is the first of the slot that is known.
class Names {
 public:
  void add(const Incarnation& who);
  std::string operator()(const Incarnation& who) const;

 private:
  std::map<PeerId, std::uint32_t> first_;
};

/// What a session's datagrams tell, sorted by who says it; grows with the session's updates.
struct SessionLog {
  struct Voice {
    Endpoint at;
    std::int64_t last_ns = 0;                       ///< when it was heard last
    Tick last_tick = 0;                             ///< the latest mark
    std::map<std::uint32_t, sync::Bundle> updates;  ///< by number
    std::map<std::uint32_t, Tick> marks;            ///< latest tick by count
  };
  struct Check {
    Tick tick = 0;
    std::uint32_t hash = 0;
    Incarnation by;
    std::uint64_t packet = 0;  ///< the first that tells it
  };
  struct Pieces {
    std::vector<wire::Bytes> parts;
    bool complete() const;
    wire::Bytes joined() const;
  };

  std::uint16_t session = 0;
  std::int64_t first_ns = 0;
  std::uint64_t states = 0;
  std::optional<wire::Join> join;
  int slots = 0;   ///< 0: not told
  int wanted = 0;  ///< members that play waits for; 0: not told
  std::map<Incarnation, Voice> voices;
  /// Updates that others tell of a slot's log: passed on, fetched.
  std::map<std::pair<PeerId, std::uint32_t>, sync::Bundle> retold;
  std::vector<Check> checks;                                       ///< each of (tick, incarnation) once
  std::map<std::pair<Endpoint, std::uint64_t>, Pieces> transfers;  ///< by receiver and nonce
  Tick oldest = -1;                                                ///< the first mark of anybody; -1: none
  Tick newest = 0;                                                 ///< the latest mark of anybody
  Names names() const;
};

/// Why no tick of the session's confirmed world beyond its beginning follows from its packets, for people; empty if one
/// may. The world begins with the session's start, for which every update of those who were there is needed, or with a
/// whole transfer to a newcomer.
std::string nothing_to_begin_with(const SessionLog& session_log, const Contents& contents);

/// Reads sessions into session_logs.
class Bookkeeper {
 public:
  void take(const Datagram& d);
  const std::map<std::uint16_t, SessionLog>& session_logs() const { return ledgers_; }
  /// The session of that number, or, with none given, the only one. Throws UserError that lists the sessions if there
  /// is no such session, or are several and none is given.
  const SessionLog& choose(std::optional<int> session) const;
  /// State, session and membership datagrams that did not decode or had been damaged on the way.
  std::uint64_t unreadable() const { return unreadable_; }

  /// The sessions that have state datagrams, those with most of them first, for messages.
  std::string sessions() const;

 private:
  void state(const Datagram& d, const sync::StatePacket& p, PeerId sender, SessionLog& l);
  void session(const wire::SessionMessage& m, SessionLog& l);
  void membership(const Datagram& d, const wire::MembershipMessage& m, SessionLog& l);

  std::map<std::uint16_t, SessionLog> ledgers_;
  std::map<std::uint64_t, wire::Join> joins_;  ///< by nonce: a newcomer does not know the session's number yet
  std::set<std::tuple<std::uint16_t, Tick, Incarnation>> checked_;
  std::uint64_t unreadable_ = 0;
};

}  // namespace padr::capture
