#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "common/wire/seal.h"
#include "common/wire/state_scan.h"
#include "tools/capture/distribution.h"
#include "tools/capture/input.h"

namespace padr::capture {

/// A peer's incarnation: session number, slot, incarnation.
struct LifeKey {
  std::uint16_t session = 0;
  PeerId slot = kNoPeer;
  std::uint32_t incarnation = 0;
  friend auto operator<=>(const LifeKey&, const LifeKey&) = default;
};

/// What is counted of datagrams that go the same way.
struct Traffic {
  std::uint64_t datagrams = 0;
  std::uint64_t bytes = 0;           ///< on the wire, IP and UDP headers included
  std::uint64_t header_bytes = 0;    ///< of these: IP and UDP
  std::uint64_t envelope_bytes = 0;  ///< magic, kind, sender, session, checksum
  std::uint64_t update_bytes = 0;    ///< updates, the first time on their link
  std::uint64_t repeat_bytes = 0;    ///< updates that the link has carried before
  std::uint64_t mark_bytes = 0;      ///< the rest of state datagrams: marks, acknowledgements, hashes
  std::uint64_t other_bytes = 0;     ///< payload of session and membership datagrams
  std::uint64_t cut_bytes = 0;       ///< of datagrams that the capture has cut off, all but the envelope
  std::int64_t first_ns = 0;         ///< least time; captures need not be in order
  std::int64_t last_ns = 0;          ///< greatest
  std::uint32_t least_size = 0;      ///< of the UDP payload, the seal included
  std::uint32_t most_size = 0;
  double seconds() const { return static_cast<double>(last_ns - first_ns) / 1e9; }
  void add(const Datagram& d);
};

struct LifeTally {
  Endpoint at;        ///< as frames have it; of whoever carries its datagrams, if it is not known
  Endpoint place;     ///< Datagram::from
  Traffic traffic;    ///< state datagrams, to everybody
  NumberWindow told;  ///< numbers of updates
  std::array<std::uint64_t, sync::kCauses> updates{};  ///< of entities, by cause, each once
  bool left = false;
};

/// State datagrams from one incarnation to another.
struct LinkTally {
  Endpoint at;  ///< of the receiver, as frames have it; of whoever carries for it, if it is not known
  Traffic traffic;
  NumberWindow seqs;
  std::uint64_t duplicates = 0;
  std::uint64_t reordered = 0;
  std::uint64_t marks = 0;  ///< datagrams without updates
  NumberWindow told;        ///< numbers of updates, that is bundles
  std::uint64_t repeats = 0;
  Gaps gaps;      ///< between two datagrams
  Delays delays;  ///< capture time less the time of the tick of sending, on a clock whose zero is not known
  std::optional<std::int32_t> transit;  ///< 0.1 ms, the least that the receiver has told of this link
  ToldLoss told_loss;                   ///< by the receiver
  bool direct = false;                  ///< some datagrams went without a carrier
  bool passed_on = false;               ///< some were captured on both hops: at the carrier, or everywhere
  Gaps acks;                            ///< from the first time an update is here until its acknowledgement is
  std::deque<std::pair<std::uint32_t, std::int64_t>> unacked;  ///< number and time, the latest 256
};

struct LinkKey {
  LifeKey from;
  Endpoint to;  ///< Datagram::to
  std::uint32_t to_incarnation = 0;
  friend auto operator<=>(const LinkKey&, const LinkKey&) = default;
};

struct SessionTally {
  std::string scenario;  ///< as a Join tells it; empty if there is none in the capture
  bool join_seen = false;
  bool authority = true;
  int slots = 0;   ///< 0: not told
  int wanted = 0;  ///< likewise
  std::uint64_t states = 0;
  std::uint32_t first_tick = 0;
  std::uint32_t last_tick = 0;
  /// Capture time of a Ping less the session time in its Pong, the greatest: as if the way from the capture to whoever
  /// answers took no time. Tally::tick0 mends that.
  std::optional<std::int64_t> session_us;
  std::int64_t least_us = 0;  ///< capture time less tick time, least of all state datagrams
  std::uint64_t hashes = 0;   ///< told
};

/// Counts what a capture holds, datagram by datagram, in memory that does not grow with it. The second hop of a
/// datagram that is carried counts in `all` and `kinds` only.
class Tally {
 public:
  void take(const Datagram& d);

  const std::map<std::uint16_t, SessionTally>& sessions() const { return sessions_; }
  const std::map<LifeKey, LifeTally>& incarnations() const { return incarnations_; }
  const std::map<LinkKey, LinkTally>& links() const { return links_; }
  const Traffic& all() const { return all_; }
  /// By kind: state, session, membership.
  const std::array<Traffic, 3>& kinds() const { return kinds_; }
  const std::map<std::string, std::uint64_t>& messages() const { return messages_; }
  /// By reason: what receivers drop, and what the capture has cut off.
  const std::map<std::string, std::uint64_t>& dropped() const { return dropped_; }
  /// Datagrams that the capture has cut off: of which links they are is not known, nor so which others were lost.
  std::uint64_t cut() const { return cut_; }
  /// Whether what the capture lacks of a link was lost. A carrier sees what it passes on, and not what goes directly.
  bool judges(const LinkTally& link) const { return cut_ == 0 && (link.direct || !link.passed_on); }
  /// Lives and links beyond what is kept apart; their datagrams count in the sums alone.
  std::uint64_t beyond() const { return beyond_; }
  /// Capture time of tick 0 of a session in `sessions`, us, and whether that is known from Pings and Pongs; otherwise
  /// the fastest datagram counts as having taken no time.
  std::pair<std::int64_t, bool> tick0(std::uint16_t session) const;
  /// Who sits at the other end of a link; 255 if it never spoke.
  PeerId receiver(const LinkKey& link) const;

 private:
  void second_hop(const Datagram& d, const wire::Opened& o);
  void state(const Datagram& d, const wire::Opened& o);
  void state_of_life(const Datagram& d, LifeTally& who);
  std::uint64_t state_of_link(const Datagram& d, LinkTally& link);
  void acknowledge(const Datagram& d, const LifeKey& from);
  void session(const Datagram& d, const wire::Opened& o);
  void membership(const wire::Opened& o);

  std::map<std::uint16_t, SessionTally> sessions_;
  std::map<LifeKey, LifeTally> incarnations_;
  std::map<LinkKey, LinkTally> links_;
  Traffic all_;
  std::array<Traffic, 3> kinds_;
  std::map<std::string, std::uint64_t> messages_;
  std::map<std::string, std::uint64_t> dropped_;
  std::uint64_t cut_ = 0;
  std::uint64_t beyond_ = 0;
  std::map<std::pair<Endpoint, std::uint32_t>, LifeKey> who_;  ///< by address and incarnation
  std::map<std::pair<Endpoint, Micros>, std::int64_t> pings_;  ///< capture time, us, by asker and its clock
  wire::StateScan scan_;
};

}  // namespace padr::capture
