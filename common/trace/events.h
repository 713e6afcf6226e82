#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/model/endpoint.h"
#include "common/model/ids.h"
#include "common/model/state.h"
#include "common/model/technique.h"
#include "common/sync/updates.h"
#include "common/trace/metrics.h"

namespace padr::trace {

/// A trace begins with these 7 bytes and the version's byte.
inline constexpr std::string_view kMagic = "PADRTRC";
inline constexpr std::uint8_t kFormatVersion = 6;

/// Takes the next bytes of a trace; whole records at a time.
using ByteSink = std::function<void(std::span<const std::byte>)>;

/// Where a run came from: what only the program around the core knows.
struct Provenance {
  std::string program;   ///< such as padr-peer
  std::string revision;  ///< of the source
  std::vector<std::string> command;
  std::string scenario;       ///< name or file, for people
  std::string scenario_text;  ///< the scenario itself
  std::uint64_t scenario_seed = 0;
  std::string netem;  ///< what shapes this peer's outgoing links, as the option was written
  std::uint64_t netem_seed = 0;
  std::string input;         ///< as the option was written
  Micros start_unix_us = 0;  ///< wall clock at the start; 0: not told
};

/// The first record: provenance, and what a Replica and its world are built from.
struct Header : Provenance {
  PeerId peer = 0;
  int peers = 1;   ///< of the session at tick 0; not told if incarnation > 0
  int wanted = 0;  ///< members that play waits, or waited, for; 0: for nobody
  int slots = 1;
  std::uint32_t incarnation = 0;  ///< above 0: came later, and a Begin follows
  std::uint16_t session = 0;
  std::uint64_t scene_hash = 0;
  std::uint64_t fingerprint = 0;
  int bodies = 0;
  Technique technique;
  bool is_signed = false;  ///< the peer signs its updates
  bool spectates = false;  ///< the peer has no avatar
  SessionId session_id{};  ///< in every signature; all zeros: no key, or a trace from before this was told
  int entities() const { return bodies + slots; }
};

/// Whether both are of one incarnation of one peer. The two sides of a partition do not know of one another's
/// newcomers, and may number them alike.
inline bool same_incarnation(const Header& a, const Header& b) {
  return a.peer == b.peer && a.incarnation == b.incarnation && a.start_unix_us == b.start_unix_us;
}

/// What one who came while the session ran began with.
struct Begin {
  Tick tick = 0;                        ///< of the first Step
  Tick confirmed = 0;                   ///< of the first Confirmed, that of the transfer
  std::span<const std::byte> transfer;  ///< as common/wire encodes it
};

// What is asked of a replica about who is there; as in node::Replica.

struct Order {
  std::span<const std::byte> fetched;  ///< a wire::Fetched with the update, as common/wire encodes it
};

/// Updates of a peer that is not heard, as another has them; as in node::Replica.
struct Relayed {
  std::span<const std::byte> fetched;  ///< a wire::Fetched, as common/wire encodes it
};

struct Freeze {
  PeerId peer = kNoPeer;
  bool frozen = false;
};

struct GiveUp {
  PeerId peer = kNoPeer;
};

struct Excuse {};

// What is done to a peer from outside while it plays.

/// It plays by these knobs from the next step on.
struct Retune {
  Technique technique;
};

/// A body is pushed, as in node::Replica.
struct Push {
  static constexpr float kMost = 1000;  ///< m/s, in x and in y
  EntityId body = 0;
  Vec2 velocity;  ///< m/s
};

/// For people: what its core does not know of, such as an impairment of its links.
struct Remark {
  std::string kind;  ///< one word
  PeerId peer = kNoPeer;
  std::string text;
};

/// What a step took in and how it went; the live world after it is told beside it.
struct Step {
  Tick tick = 0;  ///< after the step; 0: the state before the first
  Vec2 target;    ///< m
  bool leaving = false;
  bool outside = false;  ///< the avatar is not, or not yet, a part of the session, or play has not begun
  std::uint64_t live_hash = 0;
  float threshold = 0;               ///< m
  float own_error = 0;               ///< m
  Micros lateness = 0;               ///< of the step's begin against tick_start
  std::uint64_t replayed_steps = 0;  ///< total
  std::uint32_t snaps = 0;           ///< total
  double snap_m = 0;                 ///< total, m
  /// Of the update that the step published, if it did and the peer signs: nothing else can make it again.
  std::optional<sync::Signature> signature;
};

/// The live world of one tick.
struct LiveView {
  std::vector<BodyState> states;  ///< by entity
  std::vector<Vec2> shown;        ///< m, by entity
};

struct Received {
  Micros at = 0;  ///< session time
  std::span<const std::byte> datagram;
};

struct Sent {
  PeerId to = kNoPeer;
  Tick tick = 0;
  std::span<const std::byte> datagram;
};

struct Confirmed {
  Tick tick = 0;
  std::uint64_t hash = 0;
};

/// Datagrams that were not taken of whoever sat in a slot, by reason.
struct Dropped {
  PeerId peer = kNoPeer;
  std::vector<std::uint64_t> by_reason;
};

/// Counters at a clean end, as in node::ReplicaStats.
struct Footer {
  std::uint64_t bundles = 0;
  std::vector<std::uint64_t> updates_by_cause;
  std::uint64_t repeats = 0;
  std::uint64_t datagrams_sent = 0;
  std::uint64_t wire_bytes_sent = 0;
  std::uint64_t datagrams_received = 0;
  std::vector<std::uint64_t> dropped;
  std::uint64_t hash_checks = 0;
  std::uint64_t hash_mismatches = 0;
  Tick first_mismatch = -1;
  bool superseded = false;          ///< the peer began another life, in another trace
  std::vector<Dropped> dropped_of;  ///< slots that something was dropped of; older traces tell none
};

/// One record after the header.
using Event = std::variant<Step, Received, Sent, Confirmed, Footer, Begin, Order, Freeze, GiveUp, Excuse, Retune, Push,
                           Remark, Relayed>;

}  // namespace padr::trace
