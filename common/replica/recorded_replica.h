#pragma once

#include <optional>
#include <string>
#include <utility>

#include "common/replica/replica.h"
#include "common/trace/trace_writer.h"
#include "common/wire/membership_codec.h"

namespace padr::node {

/// A Replica whose boundary is recorded: every input, every datagram in and out, what the live world was after every
/// step and what was confirmed. Without a recording it is a Replica and costs what a Replica costs.
///
/// What is recorded is all that a Replica depends on, so a fresh Replica that is fed a trace does the same to the bit.
class RecordedReplica {
 public:
  struct Recording {
    trace::Provenance provenance;
    trace::ByteSink sink;  ///< called during construction and every other call but the getters
  };

  RecordedReplica(const Scene& scene, const ReplicaConfig& config, std::optional<Recording> recording = {},
                  Replica::ConfirmedSink on_confirmed = {});
  /// For a peer that joins a running session, as in Replica.
  RecordedReplica(const Scene& scene, const ReplicaConfig& config, const sync::Transfer& start, Tick now,
                  std::optional<Recording> recording = {}, Replica::ConfirmedSink on_confirmed = {});
  bool catch_up(Tick most);
  // The replica's sink points to this object.
  RecordedReplica(const RecordedReplica&) = delete;
  RecordedReplica& operator=(const RecordedReplica&) = delete;

  // As in Replica. A datagram that the judge rejects is not recorded: it changes nothing in the replica but counters.
  sync::DropReason receive(const wire::Opened& opened, Micros now);
  sync::DropReason receive(std::span<const std::byte> datagram, Micros now);
  /// `lateness`: by how much the step began after the time of its tick, for the record only.
  void step(Vec2 target, Micros lateness = 0);
  // For a region of a crowd, whose peers are not recorded.
  void step_led(const BodyState& from, const BodyState& to, Vec2 target) { replica_.step_led(from, to, target); }
  void jolt(Vec2 velocity) { replica_.jolt(velocity); }
  void set_coarseness(float times) { replica_.set_coarseness(times); }
  std::span<const Outgoing> outgoing() const { return replica_.outgoing(); }
  void leave();
  void order(const sync::Bundle& order);
  void freeze(PeerId p, bool frozen);
  void excuse_tick();
  void give_up(PeerId p, bool for_good = true);
  sync::DropReason relay(const wire::Fetched& fetched, PeerId by);
  /// Sets the address of p, in a session whose peers are all present from tick 0 on.
  void locate(PeerId p, const Endpoint& at) { replica_.locate(p, at); }
  void retune(const Technique& technique);
  void push(EntityId b, Vec2 velocity);
  /// For the record only.
  void remark(const trace::Remark& r);
  void set_judge(Replica::Judge judge) { replica_.set_judge(std::move(judge)); }
  void count_drop(PeerId p, sync::DropReason why) { replica_.count_drop(p, why); }
  /// Datagrams of p are ignored from now on: records that, and gives p up, unless others hear it.
  void cut_off(PeerId p, const std::string& why);
  std::vector<MemberChange> take_changes() { return replica_.take_changes(); }

  const Replica& replica() const { return replica_; }

  /// Ends the trace as complete. Nothing may be called afterwards but the getters. `superseded`: the peer goes on in a
  /// new incarnation.
  void finish(bool superseded = false);

 private:
  Replica::ConfirmedSink traced(bool authority, Replica::ConfirmedSink sink);
  sync::DropReason record(std::span<const std::byte> datagram, Micros now, sync::DropReason why);
  void record_step(Vec2 target, Micros lateness);

  std::optional<trace::TraceWriter> writer_;  ///< before the replica, which confirms tick 0 while it is built
  trace::LiveView view_;
  bool leaving_ = false;
  bool stepped_ = false;  ///< something has been shown
  Replica replica_;
};

/// The header of a trace of a replica built from these.
trace::Header trace_header(const Scene& scene, const ReplicaConfig& config, const trace::Provenance& provenance);

}  // namespace padr::node
