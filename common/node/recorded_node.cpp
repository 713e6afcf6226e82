#include "common/node/recorded_node.h"

#include <algorithm>

#include "common/trace/truth.h"
#include "common/wire/transfer_codec.h"

namespace padr::node {
namespace {

std::optional<trace::TraceWriter> writer_for(const Scene& scene, const NodeConfig& config,
                                             std::optional<RecordedNode::Recording> recording) {
  if (!recording) return std::nullopt;
  return trace::TraceWriter(trace_header(scene, config, recording->provenance), std::move(recording->sink));
}

std::optional<trace::TraceWriter> writer_for(const Scene& scene, const NodeConfig& config, const sync::Transfer& start,
                                             Tick now, std::optional<RecordedNode::Recording> recording) {
  auto writer = writer_for(scene, config, std::move(recording));
  if (writer) writer->begin({now, start.state.tick, wire::encode_transfer(start)});
  return writer;
}

}  // namespace

trace::Header trace_header(const Scene& scene, const NodeConfig& config, const trace::Provenance& provenance) {
  trace::Header h;
  static_cast<trace::Provenance&>(h) = provenance;
  h.peer = config.self;
  h.peers = config.peers;
  h.slots = config.slots;
  h.incarnation = config.incarnation;
  h.session = config.session;
  h.scene_hash = scene_hash(scene);
  h.fingerprint = world::physics_fingerprint();
  h.bodies = static_cast<int>(scene.bodies.size());
  h.technique = config.technique;
  h.is_signed = static_cast<bool>(config.sign);
  return h;
}

RecordedNode::RecordedNode(const Scene& scene, const NodeConfig& config, std::optional<Recording> recording,
                           Node::ConfirmedSink on_confirmed)
    : writer_(writer_for(scene, config, std::move(recording))),
      node_(scene, config, traced(config.technique.authority, std::move(on_confirmed))) {
  if (writer_) record_step({}, 0);
}

RecordedNode::RecordedNode(const Scene& scene, const NodeConfig& config, const sync::Transfer& start, Tick now,
                           std::optional<Recording> recording, Node::ConfirmedSink on_confirmed)
    : writer_(writer_for(scene, config, start, now, std::move(recording))),
      node_(scene, config, start, now, traced(config.technique.authority, std::move(on_confirmed))) {}

bool RecordedNode::catch_up(Tick most) {
  if (!node_.catch_up(most)) return false;
  if (writer_) record_step({}, 0);
  return true;
}

Node::ConfirmedSink RecordedNode::traced(bool authority, Node::ConfirmedSink sink) {
  return [this, authority, sink = std::move(sink)](const sync::FoldState& s, const sync::LazyHash& hash) {
    if (writer_) writer_->confirmed(s.tick, hash, trace::truth_of(s, authority));
    if (sink) sink(s, hash);
  };
}

sync::DropReason RecordedNode::receive(std::span<const std::byte> datagram, Micros now) {
  const sync::DropReason why = node_.receive(datagram, now);
  const bool judged = why == sync::DropReason::kSignature || why == sync::DropReason::kRight;
  if (writer_ && !judged) writer_->received(now, datagram);
  return why;
}

void RecordedNode::order(const sync::Bundle& order) {
  if (writer_) {
    sync::Bundle told = order;
    told.peer = node_.self();
    writer_->order({wire::encode_membership(wire::Fetched{told.peer, 0, {told}})});
  }
  node_.order(order);
}

void RecordedNode::freeze(PeerId p, bool frozen) {
  if (writer_) writer_->freeze({p, frozen});
  node_.freeze(p, frozen);
}

void RecordedNode::give_up(PeerId p, bool for_good) {
  if (writer_) writer_->give_up({p});
  node_.give_up(p, for_good);
}

sync::DropReason RecordedNode::relay(const wire::Fetched& fetched) {
  const sync::DropReason why = node_.relay(fetched.slot, fetched.incarnation, fetched.updates);
  if (writer_ && why == sync::DropReason::kNone) writer_->relayed({wire::encode_membership(fetched)});
  return why;
}

void RecordedNode::excuse_silence() {
  if (writer_) writer_->excuse();
  node_.excuse_silence();
}

void RecordedNode::locate(PeerId p, const Endpoint& at) {
  if (writer_) writer_->locate({p, at});
  node_.locate(p, at);
}

void RecordedNode::retune(const Technique& technique) {
  if (writer_) writer_->retune({technique});
  node_.retune(technique);
}

void RecordedNode::push(EntityId b, Vec2 velocity) {
  if (writer_) writer_->push({b, velocity});
  node_.push(b, velocity);
}

void RecordedNode::cut_off(PeerId p, bool for_good, const std::string& why) {
  remark({"cut_off", p, why});
  node_.count_cut_off(p);
  if (for_good) give_up(p);
}

void RecordedNode::remark(const trace::Remark& r) {
  if (writer_) writer_->remark(r);
}

void RecordedNode::step(Vec2 target, Micros lateness) {
  node_.step(target);
  if (!writer_) return;
  record_step(target, lateness);
  for (const Outgoing& o : node_.outgoing()) writer_->sent(o.to, node_.now(), o.bytes);
}

void RecordedNode::leave() {
  leaving_ = true;
  node_.leave();
}

void RecordedNode::record_step(Vec2 target, Micros lateness) {
  const world::View& live = node_.live().world();
  const auto entities = static_cast<std::size_t>(live.entities());
  view_.states.resize(entities);
  for (EntityId e = 0; e < entities; ++e) view_.states[e] = live.state(e);
  view_.shown = node_.shown().positions();
  // Nothing has been shown before the first step.
  if (!stepped_)
    for (EntityId e = 0; e < entities; ++e) view_.shown[e] = view_.states[e].position;
  stepped_ = true;
  trace::Step s;
  s.tick = node_.now();
  s.target = target;
  s.leaving = leaving_;
  s.outside = !node_.member();
  s.live_hash = node_.live_hash();
  s.threshold = node_.threshold();
  s.own_error = node_.own_error();
  s.lateness = lateness;
  s.replayed_steps = node_.agreed().replayed_steps();
  s.snaps = static_cast<std::uint32_t>(node_.shown().snaps());
  s.snap_m = node_.shown().snap_metres();
  s.signature = node_.signed_now();
  writer_->step(s, view_);
}

void RecordedNode::finish(bool superseded) {
  if (!writer_) return;
  const NodeStats& n = node_.stats();
  trace::Footer f;
  f.bundles = n.bundles;
  f.updates_by_cause.assign(n.updates_by_cause.begin(), n.updates_by_cause.end());
  f.repeats = n.repeats;
  f.datagrams_sent = n.datagrams_sent;
  f.wire_bytes_sent = n.wire_bytes_sent;
  f.datagrams_received = n.datagrams_received;
  f.dropped.assign(n.dropped.begin(), n.dropped.end());
  f.hash_checks = n.hash_checks;
  f.hash_mismatches = n.hash_mismatches;
  f.first_mismatch = n.first_mismatch;
  f.superseded = superseded;
  for (PeerId p = 0; p < node_.config().slots; ++p) {
    const auto& dropped = node_.other(p).dropped;
    if (std::any_of(dropped.begin(), dropped.end(), [](std::uint64_t d) { return d > 0; }))
      f.dropped_of.push_back({p, {dropped.begin(), dropped.end()}});
  }
  writer_->footer(f);
}

}  // namespace padr::node
