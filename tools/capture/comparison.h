#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "common/trace/events.h"
#include "tools/capture/input.h"
#include "tools/capture/session_log.h"

namespace padr::capture {

/// What one peer's trace says of state datagrams and of the confirmed world.
struct TraceStory {
  std::string label;
  trace::Header header;
  bool clean = false;       ///< it ends as it should
  bool superseded = false;  ///< the peer gave this incarnation up for another one
  Tick last_tick = -1;      ///< the last step that it tells of
  std::map<Tick, std::uint64_t> confirmed;
  Incarnation who() const { return {header.peer, header.incarnation}; }
};

/// One state datagram of a link, wherever it was seen.
struct Passage {
  std::uint32_t seq = 0;
  Tick tick = 0;
  std::uint32_t sent = 0;  ///< by the sender's trace
  std::uint32_t captured = 0;
  std::uint32_t received = 0;  ///< by the receiver's trace
};

struct LinkStory {
  Incarnation from, to;
  bool sender_told = false;    ///< there is a trace of it
  bool receiver_told = false;  ///< likewise
  std::uint64_t sent = 0, captured = 0, received = 0, duplicates = 0;
  /// Datagrams of which the capture has not all (snaplen), so that they cannot be told from one another. If there are
  /// any, nothing is judged.
  std::uint64_t cut = 0;
  /// Before the first or after the last datagram that the capture has of it; of a link that was captured by a carrier
  /// only, what it did not pass on, too.
  std::uint64_t outside = 0;
  std::vector<Passage> lost_before;     ///< sent, and not in the capture: lost before it came there
  std::vector<Passage> lost_after;      ///< in the capture and not received
  std::vector<Passage> after_trace;     ///< in the capture, after the sender's or the receiver's trace broke off
  std::vector<Passage> contradictions;  ///< what loss cannot explain
};

/// Capture against traces, datagram by datagram.
class Comparison {
 public:
  /// Throws UserError if the trace is damaged, of another session, or of a peer's incarnation that has one already.
  void add_trace(const std::string& file);
  void add(const Datagram& d);

  const std::vector<TraceStory>& traces() const { return traces_; }
  /// Links of the traces' session, by sender and receiver. Those of which the capture has nothing have captured == 0.
  std::vector<LinkStory> links() const;
  /// Datagrams that the capture has cut off.
  std::uint64_t cut() const { return cut_; }
  /// Datagrams of which some bits were turned on the way: in the capture, received, and received but not captured.
  std::uint64_t damaged() const { return damaged_; }
  std::uint64_t damaged_received() const { return damaged_received_; }

 private:
  struct Key {
    Incarnation from, to;
    std::uint64_t content = 0;
    friend auto operator<=>(const Key&, const Key&) = default;
  };
  struct Captured {
    Incarnation from;
    Endpoint at;  ///< from which it was sent
    Endpoint to;
    std::uint32_t to_incarnation = 0;
    std::uint64_t content = 0;
    std::uint32_t seq = 0;
    Tick tick = 0;
    bool carried = false;
    bool second_hop = false;
  };
  void from_trace(std::span<const std::byte> datagram, const TraceStory& story, PeerId to);
  /// By the address that it was sent to, or, where the capture has nothing that was sent from there, by the traces.
  Incarnation receiver_of(const Captured& c) const;

  std::vector<TraceStory> traces_;
  std::map<Key, Passage> told_;  ///< by the traces
  std::vector<Captured> captured_;
  std::map<std::pair<Endpoint, std::uint32_t>, PeerId> who_;
  std::map<std::pair<Endpoint, Endpoint>, std::uint64_t> cut_on_;  ///< by from where and to where
  std::uint64_t cut_ = 0;
  std::uint64_t damaged_ = 0;
  std::uint64_t damaged_received_ = 0;
};

}  // namespace padr::capture
