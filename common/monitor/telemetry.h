#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/model/endpoint.h"
#include "common/model/ids.h"
#include "common/model/vec.h"
#include "common/sync/updates.h"
#include "common/sync/validation.h"

namespace padr::monitor {

/// Who tells: in everything that a peer tells, so that each datagram stands for itself.
struct Origin {
  std::uint64_t process = 0;  ///< drawn at random when the program begins
  std::uint16_t session = 0;
  PeerId slot = kNoPeer;          ///< kNoPeer: not playing yet
  std::uint32_t incarnation = 0;  ///< in its slot: another after it was declared gone and came back
  friend bool operator==(const Origin&, const Origin&) = default;
};

/// Which views of its world a peer tells.
enum class Detail : std::uint8_t {
  kShown,  ///< what its user sees
  kLive,   ///< and what it simulates, without convergence: what inconsistency is measured with
  kAll,    ///< and what it predicts, that is, believes that the others believe; and the confirmed world
};

/// Who a peer is and how it plays; told once a second, and at once when something of it changes.
struct Hello {
  std::string version;      ///< of the program, with its revision
  bool control = false;     ///< whether it takes orders from whom it tells
  std::uint64_t token = 0;  ///< to be in every order
  Endpoint at;              ///< where it plays, as far as it knows
  int slots = 0;            ///< of the session
  int incarnation = 0;      ///< counted from 0
  std::string scenario;     ///< name or file, for people
  std::uint64_t scenario_seed = 0;
  std::uint64_t scene_hash = 0;
  std::uint32_t scenario_bytes = 0;  ///< length of the text, which comes in pieces; 0: it is not told
  std::string technique;             ///< as padr::describe has it: the name and every knob
  std::string netem;                 ///< what its links out suffer unless told otherwise; empty: nothing
  std::string input;                 ///< as the option was written
  int rate = 0;                      ///< frames a second
  Detail detail = Detail::kAll;
  friend bool operator==(const Hello&, const Hello&) = default;
};

/// A piece of the scenario's text, from which scenarios::load makes the scene with the seed in Hello.
struct ScenarioPart {
  std::uint64_t scene_hash = 0;
  std::uint32_t total = 0;   ///< bytes of the whole text
  std::uint32_t offset = 0;  ///< of this piece
  std::string text;
  friend bool operator==(const ScenarioPart&, const ScenarioPart&) = default;
};

struct Place {
  Vec2 position;    ///< m; told to the millimetre
  float angle = 0;  ///< rad, -pi .. pi; told to the milliradian
  friend bool operator==(const Place&, const Place&) = default;
};

/// What is known of one entity besides where it is.
struct EntityFlags {
  bool present = false;
  bool awake = false;
  bool held = false;       ///< the avatar of who tells it touches the body
  PeerId owner = kNoPeer;  ///< who has authority over it; an avatar's is its peer
  friend bool operator==(const EntityFlags&, const EntityFlags&) = default;
};

/// A peer's world after a step. A datagram has a range of entities: `first` and as many as `flags` has, of `total`.
struct Frame {
  Tick tick = 0;
  float threshold = 0;         ///< m, in force for the avatar
  Vec2 target;                 ///< m, where the avatar is driven
  bool driven = false;         ///< by an order, not by the peer's own input
  bool holding = false;        ///< the avatar touches a body
  bool interaction = false;    ///< predicted to matter to bodies
  bool unowned_alone = false;  ///< bodies that nobody owns play out in its world alone: see plays_unowned_alone
  Tick contact_in = -1;        ///< ticks until the predicted contact; -1: none predicted
  float level = 0;             ///< 0 .. 1, how much it is predicted to matter
  float radius = 0;            ///< m, of the surroundings that are looked at
  EntityId first = 0;
  EntityId total = 0;  ///< entities of the world: bodies, then avatar slots
  std::vector<EntityFlags> flags;
  // By entity from `first` on, as long as `flags`, or empty if not told:
  std::vector<Place> shown;
  std::vector<Place> live;
  std::vector<Place> predicted;
  friend bool operator==(const Frame&, const Frame&) = default;
};

/// The confirmed world of a tick of which there is a frame, too; told once it is confirmed. Ranges as in Frame; `held`
/// says nothing here.
struct Agreed {
  Tick tick = 0;
  std::uint64_t hash = 0;
  EntityId first = 0;
  EntityId total = 0;
  std::vector<EntityFlags> flags;
  std::vector<Place> at;
  friend bool operator==(const Agreed&, const Agreed&) = default;
};

/// A link with another peer, as seen from the one that tells.
struct LinkStatus {
  PeerId to = kNoPeer;
  std::uint32_t incarnation = 0;
  bool there = false;       ///< false: has left or was declared gone
  Endpoint at;              ///< not set if not known
  float round_trip_ms = 0;  ///< smoothed
  bool measured = false;    ///< the next three are
  // What recent datagrams from there took, from the start of the tick of sending, by the two session clocks: may be
  // negative. Of the last 3 to 6 s, and of the latest 128 datagrams of the last 5 s.
  float delay_least_ms = 0;
  float delay_p50_ms = 0;
  float delay_p95_ms = 0;
  // Loss of datagrams from there: of those that were sent but for the newest 8, the ones that did not come.
  float loss_in = 0;            ///< share of the latest ones, 0 .. 1
  std::uint32_t loss_of = 0;    ///< of how many, 192 at most; 0: of none yet
  std::uint64_t lost_in = 0;    ///< of all since the link began
  std::uint64_t judged_in = 0;  ///< of how many
  float silence_ms = 0;         ///< since anything valid came
  // To there:
  float carries_kbit_s = 0;  ///< 0: no limit was found
  float queue_ms = 0;        ///< how long datagrams wait in the link's queue
  PeerId carrier = kNoPeer;  ///< the member that carries; kNoPeer: it is reached directly
  bool cut_out = false;      ///< cut by an order: nothing goes there
  bool cut_in = false;       ///< nothing is taken from there
  std::string netem;         ///< what the link out suffers; empty: nothing
  /// Datagrams from there that were not taken, by reason; of whoever has sat in the slot in this incarnation of the
  /// teller's.
  std::array<std::uint64_t, sync::kDropReasons> dropped{};
  std::uint32_t cut_offs = 0;  ///< how often who sits there now was given a deaf ear, for good or for a while
  friend bool operator==(const LinkStatus&, const LinkStatus&) = default;
};

/// How a peer does; told some times a second. Counters are since the peer began, over all its lives.
struct Status {
  Tick tick = 0;
  std::array<std::uint64_t, sync::kCauses> updates_by_cause{};
  std::uint64_t datagrams_sent = 0;
  std::uint64_t bytes_sent = 0;  ///< IP and UDP headers included
  std::uint64_t repeats = 0;
  std::uint64_t datagrams_received = 0;
  std::uint64_t dropped = 0;  ///< of those received
  Tick confirmed = -1;        ///< newest confirmed tick
  std::uint64_t hash = 0;     ///< of it
  std::uint64_t hash_checks = 0;
  std::uint64_t hash_mismatches = 0;
  std::uint64_t replayed_steps = 0;
  std::uint64_t steps = 0;         ///< ticks played
  std::uint64_t late_ticks = 0;    ///< begun more than a tick after their time
  std::int64_t worst_late_us = 0;  ///< of any
  std::int64_t clock_lead_us = 0;  ///< of this peer's session clock before the most senior other peer's
  float own_error_m = 0;           ///< live against predicted, over what it owns
  float price = 1;                 ///< all thresholds are multiplied by it, 1 or more: see sync::price_of
  std::uint32_t snaps = 0;         ///< jumps of shown positions, of this incarnation
  double snap_m = 0;               ///< their sum
  int present = 0;                 ///< peers that are there, this one included
  bool paused = false;
  std::uint64_t untold = 0;  ///< datagrams to the monitor that the system would not take
  /// Of a datagram those that it has room for: several of the same tick together have all.
  std::vector<LinkStatus> links;
  friend bool operator==(const Status&, const Status&) = default;
};

enum class EventKind : std::uint8_t {
  kContactBegin,  ///< the peer's avatar touches `entity`
  kContactEnd,    ///< it has let go of it
  kAuthority,     ///< `entity` is `peer`'s, as this peer predicts
  kRelease,       ///< `entity` is nobody's any more
  kJoined,        ///< `peer` came in
  kLeft,          ///< `peer` said goodbye
  kRemoved,       ///< `peer` was declared gone
  kLife,          ///< this peer begins to play; again if it is not its first incarnation
  kEnd,           ///< this peer has ended; `text`: why
  kMismatch,      ///< confirmed worlds differ
  kDrive,         ///< an order drives the avatar from now on
  kDriveEnd,      ///< the own input does again
  kKnob,          ///< `text`: which and how
  kNetem,         ///< of the link to `peer`, or of all
  kCut,           ///< the link with `peer`, or all, are cut
  kCutEnd,        ///< they are whole again
  kPause,         ///< this peer stands still
  kPauseEnd,
  kPush,     ///< `entity` was pushed
  kRefused,  ///< an order was not followed; `text`: why
};
inline constexpr std::size_t kEventKinds = 20;
inline constexpr std::array<std::string_view, kEventKinds> kEventNames{
    "contact_begin", "contact_end", "authority", "release",   "joined",    "left",   "removed",
    "life",          "end",         "mismatch",  "drive",     "drive_end", "knob",   "netem",
    "cut",           "cut_end",     "pause",     "pause_end", "push",      "refused"};

struct Event {
  std::uint32_t number = 0;  ///< 1, 2, 3, ... by process
  Tick tick = 0;
  EventKind kind = EventKind::kContactBegin;
  EntityId entity = kNoEntity;
  PeerId peer = kNoPeer;    ///< whom it is about, besides the one who tells; kNoPeer: nobody, or all
  std::uint32_t order = 0;  ///< number of the order that it answers; 0: none
  std::string text;         ///< for people; may be empty
  friend bool operator==(const Event&, const Event&) = default;
};

/// The newest events, oldest first. Those that a lost datagram told come again with the next ones and some while later.
struct Events {
  std::vector<Event> events;
  friend bool operator==(const Events&, const Events&) = default;
};

using Message = std::variant<Hello, ScenarioPart, Frame, Agreed, Status, Events>;

struct Told {
  Origin from;
  Message message;
};

}  // namespace padr::monitor
