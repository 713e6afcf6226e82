#pragma once

#include <optional>
#include <string>
#include <utility>

#include "common/node/node.h"
#include "common/trace/trace_writer.h"
#include "common/wire/membership_codec.h"

namespace padr::node {

/// A Node whose boundary is recorded: every input, every datagram in and out, what the live world was after every step
/// and what was confirmed. Without a recording it is a Node and costs what a Node costs.
///
/// What is recorded is all that a Node depends on, so a fresh Node that is fed a trace does the same to the bit.
class RecordedNode {
 public:
  struct Recording {
    trace::Provenance provenance;
    trace::ByteSink sink;  ///< called during construction and every other call but the getters
  };

  RecordedNode(const Scene& scene, const NodeConfig& config, std::optional<Recording> recording = {},
               Node::ConfirmedSink on_confirmed = {});
  /// One who comes while the session runs, as in Node.
  RecordedNode(const Scene& scene, const NodeConfig& config, const sync::Transfer& start, Tick now,
               std::optional<Recording> recording = {}, Node::ConfirmedSink on_confirmed = {});
  bool catch_up(Tick most);
  // The node's sink points to this object.
  RecordedNode(const RecordedNode&) = delete;
  RecordedNode& operator=(const RecordedNode&) = delete;

  // As in Node. What the judge objects to is not recorded, as it leaves no trace in the node.
  sync::DropReason receive(std::span<const std::byte> datagram, Micros now);
  /// `lateness`: by how much the step began after the time of its tick, for the record only.
  void step(Vec2 target, Micros lateness = 0);
  // Of a region of a crowd, whose nodes are not recorded.
  void step_led(const BodyState& from, const BodyState& to, Vec2 target) { node_.step_led(from, to, target); }
  void jolt(Vec2 velocity) { node_.jolt(velocity); }
  void set_coarseness(float times) { node_.set_coarseness(times); }
  std::span<const Outgoing> outgoing() const { return node_.outgoing(); }
  void leave();
  void order(const sync::Bundle& order);
  void freeze(PeerId p, bool frozen);
  void excuse_silence();
  void give_up(PeerId p, bool for_good = true);
  sync::DropReason relay(const wire::Fetched& fetched);
  void locate(PeerId p, const Endpoint& at);
  void retune(const Technique& technique);
  void push(EntityId b, Vec2 velocity);
  /// For the record only.
  void remark(const trace::Remark& r);
  void set_judge(Node::Judge judge) { node_.set_judge(std::move(judge)); }
  void count_drop(PeerId p, sync::DropReason why) { node_.count_drop(p, why); }
  /// p is not listened to any more, or not for a while: told to the trace, and given up on if it is for good.
  void cut_off(PeerId p, bool for_good, const std::string& why);
  std::vector<MemberChange> take_changes() { return node_.take_changes(); }

  const Node& node() const { return node_; }

  /// Ends the trace as complete. Nothing may be called afterwards but the getters. `superseded`: the peer goes on in
  /// another life.
  void finish(bool superseded = false);

 private:
  Node::ConfirmedSink traced(bool authority, Node::ConfirmedSink sink);
  void record_step(Vec2 target, Micros lateness);

  std::optional<trace::TraceWriter> writer_;  ///< before the node, which confirms tick 0 while it is built
  trace::LiveView view_;
  bool leaving_ = false;
  bool stepped_ = false;  ///< something has been shown
  Node node_;
};

/// The header of a trace of a node built from these.
trace::Header trace_header(const Scene& scene, const NodeConfig& config, const trace::Provenance& provenance);

}  // namespace padr::node
