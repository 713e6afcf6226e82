#include "common/replica/recorded_replica.h"

#include <algorithm>

#include "common/trace/truth.h"
#include "common/wire/transfer_codec.h"
#include "common/world/fingerprint.h"

namespace padr::node {
namespace {

std::optional<trace::TraceWriter> writer_for(const Scene& scene, const ReplicaConfig& config,
                                             std::optional<RecordedReplica::Recording> recording) {
  if (!recording) return std::nullopt;
  return trace::TraceWriter(trace_header(scene, config, recording->provenance), std::move(recording->sink));
}

std::optional<trace::TraceWriter> writer_for(const Scene& scene, const ReplicaConfig& config,
                                             const sync::Transfer& start, Tick now,
                                             std::optional<RecordedReplica::Recording> recording) {
  auto writer = writer_for(scene, config, std::move(recording));
  if (writer) writer->begin({now, start.state.tick, wire::encode_transfer(start)});
  return writer;
}

}  // namespace

trace::Header trace_header(const Scene& scene, const ReplicaConfig& config, const trace::Provenance& provenance) {
  trace::Header h;
  static_cast<trace::Provenance&>(h) = provenance;
  h.peer = config.self;
  h.peers = config.peers;
  h.wanted = config.wanted;
  h.slots = config.slots;
  h.incarnation = config.incarnation;
  h.session = config.session;
  h.session_id = config.session_id;
  h.scene_hash = scene_hash(scene);
  h.fingerprint = world::physics_fingerprint();
  h.bodies = static_cast<int>(scene.bodies.size());
  h.technique = config.technique;
  h.is_signed = static_cast<bool>(config.sign);
  h.spectates = config.spectates;
  return h;
}

RecordedReplica::RecordedReplica(const Scene& scene, const ReplicaConfig& config, std::optional<Recording> recording,
                                 Replica::ConfirmedSink on_confirmed)
    : writer_(writer_for(scene, config, std::move(recording))),
      replica_(scene, config, traced(config.technique.authority, std::move(on_confirmed))) {
  if (writer_) record_step({}, 0);
}

RecordedReplica::RecordedReplica(const Scene& scene, const ReplicaConfig& config, const sync::Transfer& start, Tick now,
                                 std::optional<Recording> recording, Replica::ConfirmedSink on_confirmed)
    : writer_(writer_for(scene, config, start, now, std::move(recording))),
      replica_(scene, config, start, now, traced(config.technique.authority, std::move(on_confirmed))) {}

bool RecordedReplica::catch_up(Tick most) {
  if (!replica_.catch_up(most)) return false;
  if (writer_) record_step({}, 0);
  return true;
}

Replica::ConfirmedSink RecordedReplica::traced(bool authority, Replica::ConfirmedSink sink) {
  return [this, authority, sink = std::move(sink)](const sync::FoldState& s, const sync::LazyHash& hash) {
    if (writer_) writer_->confirmed(s.tick, hash, trace::truth_of(s, authority));
    if (sink) sink(s, hash);
  };
}

sync::DropReason RecordedReplica::receive(const wire::Opened& opened, Micros now) {
  return record(opened.datagram, now, replica_.receive(opened, now));
}

sync::DropReason RecordedReplica::receive(std::span<const std::byte> datagram, Micros now) {
  return record(datagram, now, replica_.receive(datagram, now));
}

sync::DropReason RecordedReplica::record(std::span<const std::byte> datagram, Micros now, sync::DropReason why) {
  if (writer_ && !replica_.judge_objected()) writer_->received(now, datagram);
  return why;
}

void RecordedReplica::order(const sync::Bundle& order) {
  if (writer_) {
    sync::Bundle told = order;
    told.peer = replica_.self();
    writer_->order({wire::encode_membership(wire::Fetched{told.peer, 0, {told}})});
  }
  replica_.order(order);
}

void RecordedReplica::freeze(PeerId p, bool frozen) {
  if (writer_) writer_->freeze({p, frozen});
  replica_.freeze(p, frozen);
}

void RecordedReplica::give_up(PeerId p, bool for_good) {
  if (writer_) writer_->give_up({p});
  replica_.give_up(p, for_good);
}

sync::DropReason RecordedReplica::relay(const wire::Fetched& fetched, PeerId by) {
  const sync::DropReason why = replica_.relay(fetched.slot, fetched.incarnation, fetched.updates, by);
  if (writer_ && why == sync::DropReason::kNone) writer_->relayed({wire::encode_membership(fetched)});
  return why;
}

void RecordedReplica::excuse_tick() {
  if (writer_) writer_->excuse();
  replica_.excuse_tick();
}

void RecordedReplica::retune(const Technique& technique) {
  if (writer_) writer_->retune({technique});
  replica_.retune(technique);
}

void RecordedReplica::push(EntityId b, Vec2 velocity) {
  if (writer_) writer_->push({b, velocity});
  replica_.push(b, velocity);
}

void RecordedReplica::cut_off(PeerId p, const std::string& why) {
  remark({"cut_off", p, why});
  replica_.count_cut_off(p);
  give_up(p, false);
}

void RecordedReplica::remark(const trace::Remark& r) {
  if (writer_) writer_->remark(r);
}

void RecordedReplica::step(Vec2 target, Micros lateness) {
  replica_.step(target);
  if (!writer_) return;
  record_step(target, lateness);
  for (const Outgoing& o : replica_.outgoing()) writer_->sent(o.to, replica_.now(), o.bytes);
}

void RecordedReplica::leave() {
  leaving_ = true;
  replica_.leave();
}

void RecordedReplica::record_step(Vec2 target, Micros lateness) {
  const world::View& live = replica_.live().world();
  const auto entities = static_cast<std::size_t>(live.entities());
  view_.states.resize(entities);
  for (EntityId e = 0; e < entities; ++e) view_.states[e] = live.state(e);
  view_.shown = replica_.shown().positions();
  // Nothing has been shown before the first step.
  if (!stepped_)
    for (EntityId e = 0; e < entities; ++e) view_.shown[e] = view_.states[e].position;
  stepped_ = true;
  trace::Step s;
  s.tick = replica_.now();
  s.target = target;
  s.leaving = leaving_;
  s.outside = !replica_.member() || !replica_.playing();
  s.live_hash = replica_.live_hash();
  s.threshold = replica_.threshold();
  s.own_error = replica_.own_error();
  s.lateness = lateness;
  s.replayed_steps = replica_.agreed().replayed_steps();
  s.snaps = static_cast<std::uint32_t>(replica_.shown().snaps());
  s.snap_m = replica_.shown().snap_metres();
  s.signature = replica_.signed_now();
  writer_->step(s, view_);
}

void RecordedReplica::finish(bool superseded) {
  if (!writer_) return;
  const ReplicaStats& n = replica_.stats();
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
  for (PeerId p = 0; p < replica_.config().slots; ++p) {
    const auto& dropped = replica_.link(p).dropped;
    if (std::any_of(dropped.begin(), dropped.end(), [](std::uint64_t d) { return d > 0; }))
      f.dropped_of.push_back({p, {dropped.begin(), dropped.end()}});
  }
  writer_->footer(f);
}

}  // namespace padr::node
