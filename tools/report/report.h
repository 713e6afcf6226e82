#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "common/sync/updates.h"
#include "common/trace/events.h"
#include "common/trace/fidelity.h"
#include "common/trace/flips.h"
#include "common/trace/metrics.h"
#include "common/trace/shown_meter.h"

namespace padr::report {

/// What one peer sent, or all of them.
struct Traffic {
  std::array<std::uint64_t, sync::kCauses> updates{};  ///< entity updates by cause, each once per sender
  std::uint64_t repeats = 0;                           ///< bundles sent again to somebody who had been sent them before
  std::uint64_t datagrams = 0;                         ///< to all receivers
  std::uint64_t wire_bytes = 0;                        ///< 28 B of IPv4 and UDP headers per datagram included
  /// How `wire_bytes` divides: updates by cause (first transmissions), repeats, and the rest (headers, marks,
  /// acknowledgements). Within a bundle that tells of several
  /// entities bytes are divided by estimated size.
  std::array<double, sync::kCauses> bytes_by_cause{};
  double bytes_repeats = 0;
  std::uint64_t all_updates() const;
  double bytes_rest() const;
  Traffic& operator+=(const Traffic& o);
};

/// One directed link. Delays compare session clocks: how far the two differ is in them.
struct Link {
  std::string from_name;  ///< as in Peer
  std::string to_name;
  PeerId from = kNoPeer;
  PeerId to = kNoPeer;
  std::uint64_t sent = 0;        ///< by the sender's trace
  std::uint64_t received = 0;    ///< by the receiver's, each datagram once
  std::uint64_t duplicates = 0;  ///< beyond the first of each
  std::uint64_t reordered = 0;   ///< arrived after one that had been sent later (RFC 4737)
  std::uint64_t judged = 0;      ///< sent early enough to have arrived before the traces end
  std::uint64_t lost = 0;        ///< of those
  // NaN if nothing was received, of the jitter also if one datagram was:
  double delay_mean_ms = kNaN;  ///< from the start of the tick of sending to reception
  double delay_p50_ms = kNaN;
  double delay_p95_ms = kNaN;
  double jitter_ms = kNaN;  ///< mean difference between successive arrivals' delays (RFC 3550, without its smoothing)
  static constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  double loss_percent() const;
  double reordered_percent() const;
};

/// What a peer did not take of whoever sat in a slot, all over its incarnation.
struct Drops {
  PeerId of = kNoPeer;
  std::vector<std::uint64_t> by_reason;  ///< as in sync::DropReason
  std::uint64_t cut_offs = 0;            ///< how often it stopped listening to it, for good or for a while
};

/// A link that did not work, and the member that carried for it.
struct Carried {
  PeerId to = kNoPeer;
  PeerId by = kNoPeer;
  Tick from = 0;
  Tick until = 0;
};

/// One incarnation of a peer, from its coming until it says goodbye: what it sees and sends while it makes sure that
/// everybody has its last updates is left out of inconsistency and traffic.
struct Peer {
  std::string label;  ///< the trace's file
  std::string name;   ///< its number; "3.2" is the second of whom there is a trace in slot 3
  trace::Header header;
  bool clean = false;       ///< the trace ends as it should
  bool has_rest = false;    ///< but bytes follow that are no record
  bool superseded = false;  ///< the peer went on in another incarnation
  Tick first_tick = 0;      ///< of the trace: who comes later watches first
  Tick came = 0;            ///< since when its avatar has been there
  Tick last_tick = 0;       ///< of the trace
  Tick left_at = -1;        ///< the step that said goodbye; -1: none
  Tick last_confirmed = -1;
  trace::Inconsistency inconsistency;
  std::vector<trace::InconsistencyPoint> series;
  trace::Fidelity fidelity;
  trace::FidelitySeries fidelity_series;
  std::uint64_t deeds = 0;  ///< as trace::FidelityMeter counts them
  trace::Pcc pcc;           ///< of its avatar
  trace::PccSeries pcc_series;
  Traffic traffic;
  std::vector<Traffic> per_second;
  std::uint64_t damaged = 0;     ///< datagrams received that were no datagrams of this protocol (corrupted on the way)
  std::uint64_t late_ticks = 0;  ///< steps that began more than a tick after their time
  Micros worst_lateness = 0;
  std::uint64_t replayed_steps = 0;
  std::uint32_t snaps = 0;  ///< jumps of shown positions by more than 3 cm
  double snap_m = 0;
  trace::ShownMotion shown;  ///< if the scene is known
  double threshold_mean_m = 0;
  // What was done to it while it played:
  std::uint64_t retunes = 0;                ///< its knobs were turned
  std::uint64_t pushes = 0;                 ///< it was told to push a body
  std::uint64_t remarks = 0;                ///< impairments, cuts, pauses
  std::optional<Technique> technique_last;  ///< its technique after the last of them
  std::optional<std::string> netem_last;    ///< what its links were last told to suffer, if that was changed
  /// What it dropped in all, by reason, told at a clean end only; who did not know all reasons tells fewer.
  std::vector<std::uint64_t> dropped;
  std::vector<Drops> drops;      ///< by slot, where there is something to tell
  std::vector<Carried> carried;  ///< as they began
  Tick went() const { return left_at >= 0 ? left_at : last_tick; }
  Tick played() const { return went() - came; }
  double seconds() const { return static_cast<double>(played()) / kTicksPerSecond; }
};

/// From this tick on `owner` owns the body.
struct AuthorityChange {
  Tick tick = 0;
  EntityId body = 0;
  PeerId owner = kNoPeer;
};

/// Peers of the same technique, as one.
struct Group {
  std::string technique;  ///< with all knobs
  std::vector<std::size_t> peers;
  trace::Inconsistency inconsistency;
  trace::Fidelity fidelity;
  Traffic traffic;     ///< of all of them
  double seconds = 0;  ///< likewise
};

struct ConfirmedCheck {
  std::uint64_t ticks = 0;  ///< confirmed in every trace that reaches them, and compared
  std::uint64_t mismatches = 0;
  Tick first_mismatch = -1;
  std::string who;  ///< at the first mismatch: which peers say what
  // Of incarnations that were given up for another one, as after a partition:
  std::uint64_t given_up = 0;         ///< ticks that such an incarnation had confirmed, and others too
  std::uint64_t given_up_unlike = 0;  ///< of those, others had confirmed another world
};

struct Report {
  std::vector<Peer> peers;  ///< by slot, then incarnation
  std::vector<Link> links;  ///< by sender, then receiver
  std::vector<Group> groups;
  Group overall;
  ConfirmedCheck confirmed;
  std::vector<AuthorityChange> authority;  ///< by tick, then body
  Tick authority_until = 0;
  bool fidelity_known = false;  ///< whether fidelity and physics-consistency-cost could be measured
  double left_out = 0;          ///< of fidelity, as trace::FidelityMeter says it
  std::vector<PeerId> heard;    ///< slots from which datagrams were received
  /// When play began; 0 if that is not told.
  int peers_at_start() const;
  /// Not one of those.
  bool came_later(const Peer& peer) const;
  /// Whether it has an avatar, and there is a trace of another peer that was there at the same time:
  /// physics-consistency-cost is measured in others' views.
  bool is_seen(const Peer& peer) const;
  trace::HandOvers hand_overs;                              ///< of all bodies
  std::map<EntityId, trace::HandOvers> hand_overs_by_body;  ///< of those that changed hands
  std::vector<std::string> notes;                           ///< what a reader should know before believing the figures
};

/// Steps that begin later than this after their tick's time are late.
inline constexpr Micros kLate = kMicrosPerSecond / kTicksPerSecond;

}  // namespace padr::report
