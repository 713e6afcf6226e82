#include "common/node/participant.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/model/rng.h"
#include "common/node/guard.h"
#include "common/node/session_objection.h"
#include "common/wire/signature.h"
#include "common/wire/transfer_codec.h"

namespace padr::node {
namespace {

/// A step that is later than this: the process was held up, and nobody was heard because nobody listened.
constexpr Micros kHeldUp = 400'000;
/// A transfer's tick against the session's by our clock: what lies further off is not of this session, or would take us
/// for ever to step up to. Ticks.
constexpr Tick kMostAhead = 2 * kTicksPerSecond;
constexpr Tick kMostBehind = 120 * kTicksPerSecond;
/// Between two attempts to come back.
constexpr Micros kTryAgain = 500'000;
constexpr Micros kReturnPatience = 6 * kMicrosPerSecond;
/// Between two words about datagrams that do not fit the session's key.
constexpr Micros kWarnAgain = 10 * kMicrosPerSecond;

}  // namespace

Participant::Participant(const Scene& scene, ParticipantConfig config, Micros local)
    : scene_(scene), config_(std::move(config)), local_(local), warned_(local - kWarnAgain), born_(local) {
  if (config_.gate) gate_.emplace(*config_.gate);
  config_.session.sealed = gate_.has_value();
  coming_.session = std::make_unique<Session>(config_.session, local);
}

Participant::~Participant() = default;

NodeConfig Participant::node_config(const Session& session) const {
  NodeConfig c = config_.node;
  c.self = session.self();
  c.slots = session.slots();
  c.session = session.number();
  c.incarnation = session.incarnation();
  if (gate_)
    c.sign = [key = gate_->signing_key(), said = wire::Said{c.session, c.incarnation}](const sync::Bundle& b) {
      return wire::sign_update(key, said, b);
    };
  return c;
}

Node::ConfirmedSink Participant::sink() {
  if (!config_.on_confirmed) return {};
  return [this, life = lives_](const sync::FoldState& s, std::uint64_t hash) { config_.on_confirmed(life, s, hash); };
}

void Participant::receive(const Endpoint& from, std::span<const std::byte> datagram, Micros local) {
  local_ = local;
  if (!gate_) return take(from, datagram, local);
  const auto arrival = gate_->receive(from, datagram, local);
  if (arrival) return take(arrival->from, arrival->datagram, local);
  warn_of_drops(from, local);
}

// Who has another key or none at all keeps trying: somebody should know why nobody answers.
void Participant::warn_of_drops(const Endpoint& place, Micros local) {
  const auto& dropped = gate_->stats().dropped;
  const std::uint64_t drops =
      dropped[static_cast<std::size_t>(GateDrop::kUnsealed)] + dropped[static_cast<std::size_t>(GateDrop::kTag)];
  if (drops == drops_told_ || local - warned_ < kWarnAgain) return;
  notes_.push_back({true, std::to_string(drops - drops_told_) + " datagrams were not made with this session's key, " +
                              "the last by " + to_string(place)});
  drops_told_ = drops;
  warned_ = local;
}

void Participant::post(const Endpoint& to, PeerId state_to, std::span<const std::byte> bytes) {
  if (!config_.tamper) return hand_over(to, state_to, bytes);
  for (const Parcel& p : config_.tamper({to, state_to, wire::Bytes(bytes.begin(), bytes.end())}))
    hand_over(p.to, p.state_to, p.bytes);
}

void Participant::hand_over(const Endpoint& to, PeerId state_to, std::span<const std::byte> bytes) {
  if (gate_) return gate_->send(to, state_to, bytes, local_);
  outgoing_.add(to, state_to, bytes);
}

void Participant::take(const Endpoint& from, std::span<const std::byte> datagram, Micros local) {
  for (Life* life : {&life_, &coming_}) {
    if (!life->session) continue;
    const auto peer = life->session->receive(from, datagram, local);
    if (!peer || !life->node) continue;
    if (life->membership && !life->membership->hears(*peer)) {
      life->node->count_drop(*peer, sync::DropReason::kCutOff);
      continue;
    }
    const auto why = life->node->receive(datagram, life->session->session_now(local));
    if (!life->membership || why == sync::DropReason::kNone) continue;
    if (why == sync::DropReason::kForeign) life->membership->on_stranger(from, datagram.size(), local);
    // Whoever has been held up itself finds everybody ahead of it.
    const Tick due = life->node->node().now() + 1;
    const bool behind = life->session->session_now(local) - tick_start(due) > kHeldUp;
    if (why != sync::DropReason::kTick || !behind) life->membership->on_drop(*peer, why, local);
  }
}

// Nothing proves that the network has said so: in a session with a key it does not count.
void Participant::unreachable(const Endpoint& at, Micros local) {
  if (gate_) return;
  for (Life* life : {&life_, &coming_})
    if (life->session) life->session->unreachable(at, local);
}

void Participant::advance(Micros local) {
  local_ = local;
  for (Life* life : {&life_, &coming_})
    if (life->session && local >= life->session->next_due()) life->session->advance(local);
  if (coming_.session) be_born(local);
  collect(life_);
  collect(coming_);
}

void Participant::be_born(Micros local) {
  Session& s = *coming_.session;
  if (s.phase() == SessionPhase::kFailed && life_.session) {
    collect(coming_);
    coming_ = {};
    try_again_ = local + kTryAgain;
  } else if (s.lost_doorkeeper()) {
    ask_again(local);
  } else if (!coming_.node && (s.phase() == SessionPhase::kStarted || s.may_enter())) {
    if (!has_room_for(s)) return;
    if (s.phase() == SessionPhase::kStarted && config_.session.begins_at && !config_.session.join)
      found_region();
    else if (s.phase() == SessionPhase::kStarted)
      begin_at_tick_0();
    else
      begin_later(local);
  } else if (coming_.node && coming_.node->node().member()) {
    s.admitted();
    take_over();
  } else if (coming_.node) {
    watch(coming_, local);
  }
}

// Who was letting us in for the first time has ended: somebody else will.
void Participant::ask_again(Micros local) {
  SessionConfig c = config_.session;
  if (c.patience > 0) c.patience -= local - born_;
  if (config_.session.patience > 0 && c.patience <= 0) return;
  collect(coming_);
  coming_ = {};
  c.seed = derive_seed(c.seed, 0xA6A, ++tries_);
  coming_.session = std::make_unique<Session>(c, local);
}

// The number of slots is the founder's to say: it may be mistaken, or lie.
bool Participant::has_room_for(Session& session) const {
  const std::size_t places = scene_.avatar.spawns.size();
  if (static_cast<std::size_t>(session.slots()) <= places) return true;
  session.desk().fail("the session has more avatar slots (" + std::to_string(session.slots()) +
                      ") than the scenario has places to start from (" + std::to_string(places) + ")");
  return false;
}

// Not in yet: steps along, so that it is up to date when it is.
void Participant::watch(Life& life, Micros local) {
  while (tick_start(life.node->node().now() + 1) <= life.session->session_now(local)) {
    life.node->step({});
    life.membership->advance(local);
  }
}

void Participant::begin_at_tick_0() {
  NodeConfig c = node_config(*coming_.session);
  c.peers = static_cast<int>(coming_.session->roster().size());
  coming_.node =
      std::make_unique<RecordedNode>(scene_, c, config_.recording ? config_.recording(lives_) : std::nullopt, sink());
  take_over();
}

void Participant::found_region() {
  const NodeConfig c = node_config(*coming_.session);
  const auto now = static_cast<Tick>(*config_.session.begins_at * kTicksPerSecond / kMicrosPerSecond);
  const sync::Transfer start = sync::founding(scene_, c.slots, c.technique.authority, now, c.incarnation);
  coming_.node = std::make_unique<RecordedNode>(scene_, c, start, now,
                                                config_.recording ? config_.recording(lives_) : std::nullopt, sink());
  take_over();
}

void Participant::begin_later(Micros local) {
  Session& s = *coming_.session;
  auto transfer = wire::decode_transfer(s.transfer(), scene_, s.slots());
  if (!transfer || transfer->slots.size() <= s.doorkeeper_number()) {
    s.desk().fail("what " + to_string(s.doorkeeper()) + " sent as the agreed world does not decode");
    return;
  }
  const Tick now = static_cast<Tick>(s.session_now(local) * kTicksPerSecond / kMicrosPerSecond);
  const Tick then = transfer->state.tick;
  if (then > now + kMostAhead || then < now - kMostBehind) {
    s.desk().fail("what " + to_string(s.doorkeeper()) + " sent as the agreed world is of tick " + std::to_string(then) +
                  ", but the session is at " + std::to_string(now));
    return;
  }
  transfer->slots[s.doorkeeper_number()].at = s.doorkeeper();
  if (gate_ && !said(*transfer, s.number())) {
    s.desk().fail("what " + to_string(s.doorkeeper()) + " sent as the agreed world has updates that nobody signed");
    return;
  }
  for (sync::Transfer::Slot& slot : transfer->slots) {
    if (slot.at.is_set()) slot.at = as_seen_from(slot.at, s.doorkeeper());
    s.desk().roster.push_back(slot.at);
  }
  if (life_.node) {
    const sync::FoldState* ours = life_.node->node().agreed().confirmed_at(transfer->state.tick);
    const std::string difference = ours == nullptr ? "" : first_difference(*ours, transfer->state);
    if (!difference.empty()) s.desk().note("here and there " + difference, true);
  }
  coming_.node = std::make_unique<RecordedNode>(scene_, node_config(s), *transfer, std::max(now, transfer->state.tick),
                                                config_.recording ? config_.recording(lives_) : std::nullopt, sink());
  coming_.membership = std::make_unique<Membership>(s.desk(), *coming_.node);
  // Members among them are forgotten again; a slot's address says nothing, its peer may be gone.
  for (const Endpoint& at : transfer->gone) coming_.membership->remember(at);
  s.hand_over_to(coming_.membership.get());
  s.enter(local);
}

void Participant::take_over() {
  Life before = std::move(life_);
  life_ = std::move(coming_);
  coming_ = {};
  ++lives_;
  if (!life_.membership) {
    life_.membership = std::make_unique<Membership>(life_.session->desk(), *life_.node);
    life_.session->hand_over_to(life_.membership.get());
  }
  if (!before.session) return;
  collect(before);
  for (const Endpoint& at : before.session->roster()) life_.membership->remember(at);
  before.node->finish(true);
}

void Participant::look_for_way_back(Micros local) {
  const auto where = life_.membership->way_back();
  if (!where && coming_.session && !coming_.node) coming_ = {};  // no need any more
  if (coming_.session || local < try_again_ || !where || !where->is_set()) return;
  SessionConfig c = config_.session;
  c.join = *where;
  c.seed = derive_seed(c.seed, 0xBAC, ++tries_);
  c.patience = kReturnPatience;
  coming_.session = std::make_unique<Session>(c, local);
}

Micros Participant::next_due() const {
  Micros due = std::numeric_limits<Micros>::max();
  for (const Life* life : {&life_, &coming_})
    if (life->session) due = std::min(due, life->session->next_due());
  return due;
}

Micros Participant::next_step() const {
  return life_.session->local_at(tick_start(node().now() + 1));
}

void Participant::step(Vec2 target, Micros local) {
  const Micros lateness = before_step(local);
  life_.node->step(target, lateness);
  after_step(local);
}

void Participant::step_led(const BodyState& from, const BodyState& to, Vec2 target, Micros local) {
  before_step(local);
  life_.node->step_led(from, to, target);
  after_step(local);
}

Micros Participant::before_step(Micros local) {
  local_ = local;
  const Micros lateness = life_.session->session_now(local) - tick_start(node().now() + 1);
  if (lateness > kHeldUp) life_.node->excuse_silence();
  return lateness;
}

void Participant::after_step(Micros local) {
  life_.membership->advance(local);
  for (const Outgoing& o : life_.node->outgoing()) post(life_.session->roster()[o.to], o.to, o.bytes);
  look_for_way_back(local);
  collect(life_);
  collect(coming_);
}

void Participant::retune(const Technique& technique) {
  config_.node.technique = technique;
  for (Life* life : {&life_, &coming_})
    if (life->node) life->node->retune(technique);
}

void Participant::knock(const Endpoint& at) {
  if (life_.membership) life_.membership->knock(at);
}

void Participant::leave() {
  if (life_.node) {
    life_.node->leave();
    coming_ = {};
  } else {
    coming_.session->leave();
    collect(coming_);
  }
}

void Participant::collect(Life& life) {
  if (!life.session) return;
  for (const SessionDatagram& d : life.session->take_outgoing()) post(d.to, kNoPeer, d.bytes);
  for (SessionNote& n : life.session->take_notes()) notes_.push_back(std::move(n));
  if (!life.membership) return;
  for (const MemberChange& c : life.membership->take_changes()) changes_.push_back(c);
}

std::span<const Parcel> Participant::take_outgoing() {
  return gate_ ? gate_->take_outgoing() : outgoing_.take();
}

std::vector<SessionNote> Participant::take_notes() {
  return std::exchange(notes_, {});
}

std::vector<MemberChange> Participant::take_changes() {
  return std::exchange(changes_, {});
}

void Participant::finish() {
  if (life_.node) life_.node->finish();
}

std::string first_difference(const sync::FoldState& ours, const sync::FoldState& theirs) {
  const std::string where = "differ at tick " + std::to_string(ours.tick);
  const std::size_t bodies = ours.authority.size();
  for (std::size_t e = 0; e < ours.world.entities.size(); ++e) {
    const world::Kinematics& a = ours.world.entities[e];
    const world::Kinematics& b = theirs.world.entities[e];
    const std::string who = (e < bodies ? " body " + std::to_string(e) : " avatar " + std::to_string(e - bodies));
    const auto say = [&](const char* field, float x, float y) {
      return where + " in" + who + "'s " + field + ": " + std::to_string(x) + " here, " + std::to_string(y) + " there";
    };
    if (a.position.x != b.position.x) return say("x (m)", a.position.x, b.position.x);
    if (a.position.y != b.position.y) return say("y (m)", a.position.y, b.position.y);
    if (a.angle != b.angle) return say("angle (rad)", a.angle, b.angle);
    if (a.velocity.x != b.velocity.x) return say("x velocity (m/s)", a.velocity.x, b.velocity.x);
    if (a.velocity.y != b.velocity.y) return say("y velocity (m/s)", a.velocity.y, b.velocity.y);
    if (a.spin != b.spin) return say("spin (rad/s)", a.spin, b.spin);
    if (a.sleep_time != b.sleep_time) return say("sleep time (s)", a.sleep_time, b.sleep_time);
    if (a.awake != b.awake) return where + " in" + who + "'s being awake";
  }
  for (std::size_t b = 0; b < bodies; ++b) {
    if (ours.authority[b] != theirs.authority[b]) return where + " in body " + std::to_string(b) + "'s authority";
    if (ours.holds[b] != theirs.holds[b]) return where + " in who holds body " + std::to_string(b);
  }
  for (std::size_t b = 0; b < ours.residents.slots.size(); ++b)
    if (ours.residents.slots[b] != theirs.residents.slots[b])
      return where + " in who is in body slot " + std::to_string(b);
  if (ours.residents != theirs.residents) return where + " in which bodies have gone";
  if (ours.members != theirs.members) return where + " in who is there";
  if (ours.avatars != theirs.avatars) return where + " in an avatar's model";
  if (ours.world.contacts != theirs.world.contacts) return where + " in the contacts' memory";
  return "";
}

}  // namespace padr::node
