#include "common/monitor/sampler.h"

#include <numeric>
#include <utility>

#include "common/trace/truth.h"

namespace padr::monitor {
namespace {

float milliseconds(float ticks) {
  return ticks * 1000.0F / kTicksPerSecond;
}

Place place_of(const world::Kinematics& k) {
  return {k.position, k.angle};
}

LinkStatus link_of(const node::Replica& replica, PeerId p) {
  const node::Seat& n = replica.seat(p);
  const node::LinkState& link = replica.link(p);
  LinkStatus l;
  l.to = p;
  l.incarnation = n.incarnation;
  l.there = n.there();
  l.at = n.at;
  l.round_trip_ms = static_cast<float>(link.round_trip()) * 1e-3F;
  l.measured = link.clock.measured() && link.arrivals.any();
  if (l.measured) {
    const node::Arrivals::Delays d = link.arrivals.delays(tick_start(replica.now()));
    l.delay_least_ms = static_cast<float>(link.clock.least()) * 1e-3F;
    l.delay_p50_ms = static_cast<float>(d.median) * 1e-3F;
    l.delay_p95_ms = static_cast<float>(d.p95) * 1e-3F;
  }
  l.loss_in = link.window.loss();
  l.loss_of = static_cast<std::uint32_t>(link.window.loss_of());
  l.judged_in = link.window.counted().judged;
  l.lost_in = link.window.counted().lost;
  l.silence_ms = milliseconds(static_cast<float>(replica.roster().silence(p)));
  const sync::LinkRate& rate = link.out.rate();
  if (rate.is_limited()) l.carries_kbit_s = static_cast<float>(rate.rate() * 8 / 1000);
  l.queue_ms = milliseconds(rate.queue());
  l.dropped = link.dropped;
  l.cut_offs = link.cut_offs;
  return l;
}

}  // namespace

void Sampler::begin(const node::Replica& replica, const std::string& text) {
  const auto bodies = static_cast<std::size_t>(replica.live().world().bodies());
  owner_.assign(bodies, kNoPeer);
  held_.assign(bodies, 0);
  for (EntityId b = 0; b < bodies; ++b) owner_[b] = replica.agreed().predicted_state().authority[b].holder();
  differed_ = false;
  say({0, replica.now(), EventKind::kLife, kNoEntity, replica.self(), 0, text});
}

void Sampler::observe(const node::Replica& replica) {
  for (EntityId b = 0; b < owner_.size(); ++b) observe_body(replica, b);
  if (!differed_ && replica.stats().hash_mismatches > 0) {
    differed_ = true;
    say({0, replica.now(), EventKind::kMismatch, kNoEntity, replica.differs_from(), 0,
         "confirmed worlds differ from tick " + std::to_string(replica.stats().first_mismatch) + " on"});
  }
}

void Sampler::observe_body(const node::Replica& replica, EntityId b) {
  const PeerId owner = replica.agreed().predicted_state().authority[b].holder();
  if (owner != owner_[b])
    say({0, replica.now(), owner == kNoPeer ? EventKind::kRelease : EventKind::kAuthority, b,
         owner == kNoPeer ? owner_[b] : owner, 0, ""});
  owner_[b] = owner;
  const char held = replica.reporter().holds(b) ? 1 : 0;
  if (held != held_[b])
    say({0, replica.now(), held != 0 ? EventKind::kContactBegin : EventKind::kContactEnd, b, replica.self(), 0, ""});
  held_[b] = held;
}

void Sampler::observe(const node::MemberChange& c) {
  using Kind = node::MemberChange::Kind;
  const EventKind kind = c.kind == Kind::kAdmitted ? EventKind::kJoined
                         : c.kind == Kind::kLeft   ? EventKind::kLeft
                                                   : EventKind::kRemoved;
  say({0, c.tick, kind, kNoEntity, c.slot, 0, ""});
}

void Sampler::say(Event event) {
  event.number = ++number_;
  events_.push_back(std::move(event));
}

std::vector<Event> Sampler::take_events() {
  return std::exchange(events_, {});
}

bool Sampler::due(Tick t) const {
  const std::int64_t now = std::int64_t{t} * rate_ / kTicksPerSecond;
  const std::int64_t before = (std::int64_t{t} - 1) * rate_ / kTicksPerSecond;
  return t > 0 && now != before;
}

void Sampler::frame(const node::Replica& replica, Vec2 target, Frame& out) const {
  const world::View& live = replica.live().world();
  const sync::FoldState& predicted = replica.agreed().predicted_state();
  const Technique& technique = replica.config().technique;
  const sync::Prediction& p = replica.prediction();
  const auto entities = static_cast<std::size_t>(live.entities());
  out.tick = replica.now();
  out.threshold = replica.threshold();
  out.target = target;
  out.holding = replica.reporter().holding();
  out.interaction = p.interaction;
  out.unowned_alone = plays_unowned_alone(technique);
  out.contact_in = p.contact_in;
  out.level = p.level;
  out.radius = technique.predictor == Predictor::kNone ? 0 : technique.radius;
  out.first = 0;
  out.total = static_cast<EntityId>(entities);
  out.flags.resize(entities);
  out.shown.resize(entities);
  out.live.resize(detail_ >= Detail::kLive ? entities : 0);
  out.predicted.resize(detail_ >= Detail::kAll ? entities : 0);
  for (EntityId e = 0; e < entities; ++e) {
    const BodyState s = live.state(e);
    const bool avatar = live.is_avatar(e);
    const auto peer = static_cast<PeerId>(avatar ? e - live.bodies() : kNoPeer);
    out.flags[e] = {live.present(e), s.awake, !avatar && replica.reporter().holds(e),
                    avatar ? peer : predicted.authority[e].holder()};
    out.shown[e] = {replica.shown().positions()[e], s.angle};
    if (detail_ >= Detail::kLive) out.live[e] = {s.position, s.angle};
    if (detail_ >= Detail::kAll) out.predicted[e] = place_of(predicted.world.entities[e]);
  }
}

void Sampler::agreed(const sync::FoldState& confirmed, std::uint64_t hash, bool authority, Agreed& out) {
  const trace::Truth truth = trace::truth_of(confirmed, authority);
  const std::size_t entities = confirmed.world.entities.size();
  out.tick = confirmed.tick;
  out.hash = hash;
  out.first = 0;
  out.total = static_cast<EntityId>(entities);
  out.flags.resize(entities);
  out.at.resize(entities);
  for (std::size_t e = 0; e < entities; ++e) {
    out.flags[e] = {truth.present[e], confirmed.world.entities[e].awake, false, truth.owner[e]};
    out.at[e] = place_of(confirmed.world.entities[e]);
  }
}

Status Sampler::status(const node::Replica& replica) {
  const node::ReplicaStats& n = replica.stats();
  Status s;
  s.tick = replica.now();
  s.updates_by_cause = n.updates_by_cause;
  s.datagrams_sent = n.datagrams_sent;
  s.bytes_sent = n.wire_bytes_sent;
  s.repeats = n.repeats;
  s.datagrams_received = n.datagrams_received;
  s.dropped = std::accumulate(n.dropped.begin(), n.dropped.end(), std::uint64_t{0});
  s.confirmed = replica.agreed().confirmed().tick;
  s.hash = replica.agreed().confirmed_hash();
  s.hash_checks = n.hash_checks;
  s.hash_mismatches = n.hash_mismatches;
  s.replayed_steps = replica.agreed().replayed_steps();
  s.clock_lead_us = replica.clock_lead();
  s.own_error_m = replica.own_error();
  s.price = replica.price();
  s.snaps = static_cast<std::uint32_t>(replica.shown().snaps());
  s.snap_m = replica.shown().snap_metres();
  s.present = 1;
  for (PeerId p = 0; p < replica.config().slots; ++p) {
    if (p == replica.self()) continue;
    if (replica.seat(p).there()) ++s.present;
    if (replica.seat(p).incarnation > 0 || replica.seat(p).at.is_set() || replica.seat(p).there())
      s.links.push_back(link_of(replica, p));
  }
  return s;
}

}  // namespace padr::monitor
