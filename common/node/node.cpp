#include "common/node/node.h"

#include <algorithm>
#include <cassert>

#include "common/wire/codec.h"

namespace padr::node {
namespace {

using sync::DropReason;

// Looking ahead is the dearest thing a frame does besides physics; the low threshold lingers longer than this anyway.
constexpr Tick kLookEvery = 3;
// A link that loses less is calm: see OutLink.
constexpr float kCalmLoss = 0.02F;
// Confirmed ticks whose hash goes round.
constexpr Tick kCheckEvery = 30;
constexpr std::size_t kChecksKept = 64;
// A peer that has left and been silent for this long has ended.
constexpr Tick kDeparted = 60;
// Updates are kept this long though everybody has them: a newcomer has what its source had when it asked.
constexpr Tick kKept = 15 * kTicksPerSecond;
// Hashes go out with marks; where there is so much to tell that there are none, this often.
constexpr Tick kTellCheck = 60;
// Four marks: time to hear that somebody else leaves too, and to tell that we have everything, though some get lost.
constexpr Tick kLastAcks = 62;

void add(Hasher& h, Vec2 position, float angle, Vec2 velocity, float spin, bool awake) {
  for (const float v : {position.x, position.y, angle, velocity.x, velocity.y, spin}) h.add(v);
  h.add(static_cast<std::uint64_t>(awake));
}

}  // namespace

Node::ConfirmedSink Node::check_and(ConfirmedSink sink) {
  return [this, sink = std::move(sink)](const sync::FoldState& s, std::uint64_t hash) {
    if (s.tick % kCheckEvery == 0) checks_[s.tick] = static_cast<std::uint32_t>(hash) | 1U;
    if (checks_.size() > kChecksKept) checks_.erase(checks_.begin());
    if (sink) sink(s, hash);
  };
}

Node::Node(const Scene& scene, const NodeConfig& config, ConfirmedSink on_confirmed)
    : scene_(scene),
      config_(config),
      agreed_(scene, config.agreed(), check_and(std::move(on_confirmed))),
      live_(scene, agreed_.predicted_state(), config.self, config.technique.authority),
      reporter_(scene, config.self, config.technique),
      predictor_(scene, config.slots, config.self, config.technique),
      threshold_(config.technique),
      shown_(config.technique.convergence, static_cast<std::size_t>(live_.world().entities())),
      others_(static_cast<std::size_t>(config.slots)),
      member_(true),
      joined_(true) {
  assert(config.peers <= config.slots && config.self < config.peers);
  for (PeerId p = 0; p < config.peers; ++p) others_[p].presence = Presence::kThere;
  if (config.sign) reporter_.limit_bodies(sync::kMaxBodiesPerSigned);
  refresh_own();
}

Node::Node(const Scene& scene, const NodeConfig& config, const sync::Transfer& start, ConfirmedSink on_confirmed, Later)
    : scene_(scene),
      config_(config),
      agreed_(scene, config.agreed(), start, check_and(std::move(on_confirmed))),
      live_(scene, agreed_.predicted_state(), config.self, config.technique.authority),
      reporter_(scene, config.self, config.technique),
      predictor_(scene, config.slots, config.self, config.technique),
      threshold_(config.technique),
      shown_(config.technique.convergence, static_cast<std::size_t>(live_.world().entities())),
      others_(static_cast<std::size_t>(config.slots)) {
  assert(config.self < config.slots);
  if (config.sign) reporter_.limit_bodies(sync::kMaxBodiesPerSigned);
}

DropReason Node::receive(std::span<const std::byte> datagram, Micros now) {
  ++stats_.datagrams_received;
  PeerId sender = kNoPeer;
  const DropReason why = take(datagram, now, sender);
  if (why == DropReason::kNone) return why;
  ++stats_.dropped[static_cast<std::size_t>(why)];
  if (sender != kNoPeer) ++others_[sender].dropped[static_cast<std::size_t>(why)];
  return why;
}

void Node::count_drop(PeerId p, DropReason why) {
  ++stats_.datagrams_received;
  ++stats_.dropped[static_cast<std::size_t>(why)];
  ++others_[p].dropped[static_cast<std::size_t>(why)];
}

DropReason Node::take(std::span<const std::byte> datagram, Micros now, PeerId& sender) {
  wire::SealError seal{};
  const auto opened = wire::open(datagram, seal);
  if (!opened) return DropReason::kSeal;
  const wire::Header& h = opened->header;
  if (h.kind != wire::Kind::kState || h.session != config_.session || h.sender >= config_.slots ||
      h.sender == config_.self)
    return DropReason::kForeign;
  sender = h.sender;
  Neighbour& from = others_[h.sender];
  const auto packet = wire::decode_state(opened->payload, h.sender);
  if (!packet) return DropReason::kMalformed;
  if (!from.reachable() || from.frozen || packet->incarnation != from.incarnation ||
      packet->to_incarnation != config_.incarnation)
    return DropReason::kForeign;
  const DropReason why = sync::admit(*packet, scene_, config_.slots, this->now());
  if (why != DropReason::kNone) return why;
  for (const sync::Bundle& b : packet->updates)
    if (!agreed_.log().knows(h.sender, b.index))
      if (const DropReason wrong = sync::admit_claims(b, agreed_.confirmed()); wrong != DropReason::kNone) return wrong;
  if (!from.window.would_pass(packet->seq)) return DropReason::kDuplicate;
  if (judge_)
    if (const DropReason objection = judge_(*packet); objection != DropReason::kNone) return objection;
  from.window.pass(packet->seq);
  const DropReason filed = file_updates(*packet, h.sender);
  if (filed != DropReason::kNone) return filed;
  from.heard = this->now();
  if (packet->seen_seq > from.answered_seq) {
    from.answered_seq = packet->seen_seq;
    from.answered = this->now();
    from.proven = true;
  }
  from.link.on_packet(*packet, this->now());
  from.clock.sample(packet->mark_tick, now);
  if (packet->transit != 0) from.clock.told(packet->transit);
  take_check(*packet, h.sender);
  return DropReason::kNone;
}

DropReason Node::file_updates(const sync::StatePacket& packet, PeerId from) {
  const sync::UpdateLog& log = agreed_.log();
  // What was promised to be complete is complete: an unknown update below it contradicts its own sender.
  for (const sync::Bundle& b : packet.updates)
    if (b.index >= log.have(from) && b.tick <= log.complete(from)) return DropReason::kOrder;
  if (log.contradicts(from, packet.mark_tick, packet.mark_count)) return DropReason::kOrder;
  for (const sync::Bundle& b : packet.updates) file(b);
  // An update just filed may have been its end.
  if (agreed_.log().closed(from)) return DropReason::kNone;
  agreed_.mark(from, packet.mark_tick, packet.mark_count);
  others_[from].promised = std::max(others_[from].promised, packet.mark_count);
  return DropReason::kNone;
}

void Node::take_check(const sync::StatePacket& packet, PeerId from) {
  if (packet.check_tick < 0 || packet.check_tick % kCheckEvery != 0) return;
  others_[from].confirmed = std::max(others_[from].confirmed, packet.check_tick);
  if (packet.check_tick <= agreed_.confirmed().tick) {
    compare(packet.check_tick, packet.check_hash, from);
  } else if (pending_checks_.size() < kChecksKept) {
    std::vector<Check>& at = pending_checks_[packet.check_tick];
    if (std::none_of(at.begin(), at.end(), [from](const Check& c) { return c.from == from; }))
      at.push_back({from, others_[from].incarnation, packet.check_hash});
  }
}

void Node::settle_checks() {
  while (!pending_checks_.empty() && pending_checks_.begin()->first <= agreed_.confirmed().tick) {
    // Who has been declared gone meanwhile went its own way.
    for (const Check& c : pending_checks_.begin()->second)
      if (others_[c.from].reachable() && others_[c.from].incarnation == c.incarnation)
        compare(pending_checks_.begin()->first, c.hash, c.from);
    pending_checks_.erase(pending_checks_.begin());
  }
}

void Node::compare(Tick t, std::uint32_t theirs, PeerId from) {
  const auto mine = checks_.find(t);
  if (mine == checks_.end()) return;
  ++stats_.hash_checks;
  if (mine->second == theirs) return;
  ++stats_.hash_mismatches;
  if (stats_.first_mismatch < 0) stats_.first_mismatch = t;
  differs_from_ = std::min(differs_from_, from);
}

// The loop of the paper's Figure 5: sample input, apply received updates, step, contacts -> update; else predict, adapt
// the threshold, test the model error, update if it is exceeded.
void Node::step(Vec2 target) {
  if (agreed_.catch_up()) adopt();
  const Vec2 velocity_before = live_.world().velocity(live_.avatar());
  live_.step(target);
  agreed_.step();
  if (member_ && now() > in_since_ && !gone_ && !publish_order()) report(target, velocity_before);
  agreed_.catch_up();
  adopt();
  velocities_.resize(before_.size());
  for (EntityId e = 0; e < velocities_.size(); ++e) velocities_[e] = live_.world().velocity(e);
  shown_.advance(after_, velocities_, own_);
  agreed_.confirm();
  settle_checks();
  send();
  through_ticks_ = gone_ && all_through() ? through_ticks_ + 1 : 0;
}

bool Node::delivered() const {
  return through_ticks_ >= kLastAcks;
}

void Node::adopt() {
  refresh_own();
  read_positions(before_);
  live_.adopt(agreed_.predicted_state(), own_is_predicted() ? std::vector<bool>{} : own_);
  joined_ = member_;
  read_positions(after_);
  shown_.correct(before_, after_);
}

// Where the own entities are as predicted, the memory of their contacts may be too: then live and predicted are one,
// and drift apart only when something new happens here.
bool Node::own_is_predicted() const {
  const sync::FoldState& p = agreed_.predicted_state();
  for (EntityId e = 0; e < own_.size(); ++e) {
    if (!own_[e]) continue;
    const world::Kinematics& k = p.world.entities[e];
    if (live_.world().state(e) != BodyState{k.position, k.angle, k.velocity, k.spin, k.awake}) return false;
  }
  return config_.technique.authority;
}

void Node::refresh_own() {
  const sync::FoldState& p = agreed_.predicted_state();
  own_.assign(static_cast<std::size_t>(live_.world().entities()), false);
  for (std::size_t b = 0; b < p.authority.size(); ++b)
    own_[b] = !config_.technique.authority || p.authority[b].holder() == config_.self;
  own_[live_.avatar()] = joined_ && !gone_;
}

void Node::read_positions(std::vector<Vec2>& out) const {
  out.resize(static_cast<std::size_t>(live_.world().entities()));
  for (EntityId e = 0; e < out.size(); ++e) out[e] = live_.world().position(e);
}

void Node::report(Vec2 target, Vec2 velocity_before) {
  if (leaving_ && orders_.empty()) {
    sync::Bundle last;
    last.peer = config_.self;
    last.tick = now();
    last.leave = true;
    gone_ = true;
    ++stats_.updates_by_cause[static_cast<std::size_t>(sync::Cause::kLeave)];
    publish(std::move(last));
    return;
  }
  if (now() % kLookEvery == 0) prediction_ = predictor_.predict(live_.world(), target, agreed_.predicted_state());
  threshold_.adapt(prediction_, reporter_.holding(), now());
  sync::Reporter::Situation s;
  s.live = &live_;
  s.predicted = &agreed_.predicted_state();
  s.target = target;
  s.acceleration = (live_.world().velocity(live_.avatar()) - velocity_before) * static_cast<float>(kTicksPerSecond);
  s.threshold = threshold_.metres();
  std::uint32_t everyone = own_end();
  for (PeerId p = 0; p < config_.slots; ++p) {
    if (p == config_.self || !others_[p].there()) continue;
    s.round_trip = std::max(s.round_trip, static_cast<Tick>(others_[p].link.round_trip()) + 1);
    everyone = std::min(everyone, others_[p].link.acked());
  }
  const bool all = everyone >= own_first_ + own_log_.size();
  s.everyone_has = all ? now() - 1
                       : (everyone > own_first_ ? own_log_[everyone - own_first_ - 1].tick
                                                : (own_log_.empty() ? now() - 1 : own_log_.front().tick - 1));
  s.pushed = push_bodies();
  sync::Bundle bundle = reporter_.report(s);
  forget_pushes(bundle);
  live_.settle(bundle);
  if (bundle.avatar) ++stats_.updates_by_cause[static_cast<std::size_t>(bundle.avatar->cause)];
  for (const sync::BodyUpdate& u : bundle.bodies) ++stats_.updates_by_cause[static_cast<std::size_t>(u.cause)];
  if (bundle.avatar || !bundle.bodies.empty()) publish(std::move(bundle));
}

void Node::retune(const Technique& technique) {
  assert(technique.authority == config_.technique.authority);
  const bool other_world = technique.replay != config_.technique.replay;
  config_.technique = technique;
  reporter_.retune(technique);
  predictor_.retune(technique);
  threshold_.retune(technique);
  shown_.retune(technique.convergence, after_.empty() ? shown_.positions() : after_);
  agreed_.set_replay(technique.replay);
  if (other_world) adopt();
}

bool Node::may_push(EntityId b) const {
  if (!member_ || gone_ || leaving_ || b >= live_.world().bodies()) return false;
  return !config_.technique.authority || reporter_.may_change(agreed_.predicted_state(), b);
}

std::vector<EntityId> Node::push_bodies() {
  std::vector<EntityId> pushed;
  std::erase_if(pushes_, [this](const auto& push) { return !may_push(push.first); });
  for (const auto& [b, velocity] : pushes_) {
    live_.push(b, velocity);
    pushed.push_back(b);
  }
  return pushed;
}

// What did not fit the bundle and is not owned yet is put back to what was predicted, and has to be pushed again.
void Node::forget_pushes(const sync::Bundle& told) {
  std::erase_if(pushes_, [&](const auto& push) {
    const auto is_it = [&push](const sync::BodyUpdate& u) { return u.body == push.first && u.has_state; };
    return own_[push.first] || std::any_of(told.bodies.begin(), told.bodies.end(), is_it);
  });
}

void Node::publish(sync::Bundle bundle) {
  bundle.index = own_end();
  if (config_.sign) bundle.signature = config_.sign(bundle);
  ++stats_.bundles;
  file(bundle);
  own_log_.push_back(std::move(bundle));
}

bool Node::publish_order() {
  if (orders_.empty()) return false;
  sync::Bundle bundle = std::move(orders_.front());
  orders_.pop_front();
  bundle.peer = config_.self;
  bundle.tick = now();
  publish(std::move(bundle));
  return true;
}

Tick Node::unacknowledged(PeerId p) const {
  const std::uint32_t acked = std::max(others_[p].link.acked(), own_first_);
  if (acked >= own_end()) return 0;
  return std::max(0, now() - std::max(own_log_[acked - own_first_].tick, others_[p].excused));
}

std::optional<sync::Signature> Node::signed_now() const {
  if (own_log_.empty() || own_log_.back().tick != now()) return std::nullopt;
  return own_log_.back().signature;
}

void Node::send() {
  outgoing_.clear();
  std::uint32_t everyone = own_end();
  for (PeerId p = 0; p < config_.slots; ++p) {
    Neighbour& to = others_[p];
    if (p == config_.self || !member_ || !to.reachable() || departed(p)) continue;
    const sync::UpdateLog& log = agreed_.log();
    const bool calm = to.window.judged() && to.window.loss() < kCalmLoss && !gone_ && to.there();
    const sync::OutLink::Context context{now(), log.have(p), log.have_beyond(p), to.promised > log.have(p), calm};
    auto packet =
        to.link.compose(context, own_log_, own_first_, wire::encoded_size, wire::kMaxPayload - wire::kStateOverhead);
    everyone = std::min(everyone, to.link.acked());
    if (!packet) continue;
    fill(*packet, p);
    Outgoing o{p, wire::seal({wire::Kind::kState, config_.self, config_.session}, wire::encode(*packet))};
    ++stats_.datagrams_sent;
    stats_.wire_bytes_sent += o.bytes.size() + kIpUdpBytes;
    outgoing_.push_back(std::move(o));
  }
  stats_.repeats = repeats_of_gone_;
  for (const Neighbour& n : others_) stats_.repeats += n.link.repeats();
  keep_logs(everyone);
}

void Node::keep_logs(std::uint32_t everyone) {
  while (own_first_ < everyone && !own_log_.empty() && own_log_.front().tick < now() - kKept) {
    own_log_.pop_front();
    ++own_first_;
  }
  // Whoever falls silent may have told somebody what others lack. Nobody but a newcomer lacks what all have confirmed.
  Tick all = std::min(agreed_.confirmed().tick, now() - kKept);
  for (PeerId p = 0; p < config_.slots; ++p)
    if (p != config_.self && others_[p].there()) all = std::min(all, others_[p].confirmed);
  agreed_.keep_from(all);
}

void Node::fill(sync::StatePacket& packet, PeerId p) {
  Neighbour& to = others_[p];
  packet.incarnation = config_.incarnation;
  packet.to_incarnation = to.incarnation;
  // Marks carry what is not urgent.
  if (!packet.updates.empty() && now() - to.checked < kTellCheck) return;
  to.checked = now();
  if (to.clock.measured()) packet.transit = static_cast<std::int32_t>(to.clock.least() / 100);
  packet.loss = static_cast<std::uint32_t>(to.window.loss() * 100);
  if (checks_.empty()) return;
  packet.check_tick = checks_.rbegin()->first;
  packet.check_hash = checks_.rbegin()->second;
}

// Peers that have left linger, and want our last updates as we want theirs; one that is silent has gone for good.
bool Node::departed(PeerId p) const {
  return has_left(p) && silence(p) > kDeparted;
}

bool Node::all_through() const {
  for (PeerId p = 0; p < config_.slots; ++p) {
    if (p == config_.self || !others_[p].reachable() || departed(p)) continue;
    if (others_[p].link.acked() < own_end()) return false;
    if (agreed_.log().have(p) < others_[p].promised) return false;
  }
  return true;
}

Micros Node::clock_lead() const {
  for (PeerId p = 0; p < config_.slots; ++p)
    if (p != config_.self && others_[p].there()) return others_[p].clock.lead();
  return 0;
}

float Node::own_error() const {
  const sync::FoldState& predicted = agreed_.predicted_state();
  float sum = 0;
  for (EntityId e = 0; e < own_.size(); ++e)
    if (own_[e]) sum += distance(live_.world().position(e), predicted.world.entities[e].position);
  return sum;
}

std::uint64_t Node::live_hash() const {
  Hasher h;
  for (EntityId e = 0; e < live_.world().entities(); ++e) {
    const BodyState s = live_.world().state(e);
    add(h, s.position, s.angle, s.velocity, s.spin, s.awake);
  }
  return h.value();
}

std::uint64_t state_hash(const sync::FoldState& s) {
  Hasher h;
  for (const world::Kinematics& k : s.world.entities) add(h, k.position, k.angle, k.velocity, k.spin, k.awake);
  return h.value();
}

}  // namespace padr::node
