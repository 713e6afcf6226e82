#include "common/replica/replica.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "common/model/precision.h"
#include "common/reckoning/price.h"

namespace padr::node {
namespace {

// Ticks between look-aheads, the dearest part of a frame besides physics; the low threshold lingers longer than this.
constexpr Tick kLookEvery = 3;
// Nothing waits for the link to a peer that has not answered for so long.
constexpr Tick kGone = 2 * kTicksPerSecond;
// And for a full one no longer than this: its receiver may be lying.
constexpr Tick kHeldBack = kTicksPerSecond;

void add(Hasher& h, Vec2 position, float angle, Vec2 velocity, float spin, bool awake) {
  for (const float v : {position.x, position.y, angle, velocity.x, velocity.y, spin}) h.add(v);
  h.add(static_cast<std::uint64_t>(awake));
}

Roster roster_of(const ReplicaConfig& config) {
  Roster r;
  r.session = config.session_id;
  r.self = config.self;
  r.incarnation = config.incarnation;
  r.seats.resize(static_cast<std::size_t>(config.slots));
  return r;
}

}  // namespace

void Replica::note_time() {
  roster_.now = now();
}

Replica::ConfirmedSink Replica::check_and(ConfirmedSink sink) {
  return [this, sink = std::move(sink)](const sync::FoldState& s, const sync::LazyHash& hash) {
    if (s.tick % kCheckEvery == 0) checks_.add_own(s.tick, static_cast<std::uint32_t>(std::uint64_t{hash}) | 1U);
    if (sink) sink(s, hash);
  };
}

Replica::Replica(const Scene& scene, const ReplicaConfig& config, ConfirmedSink on_confirmed)
    : scene_(scene),
      config_(config),
      agreed_(scene, config.agreed(), check_and(std::move(on_confirmed))),
      live_(scene, agreed_.predicted_state(), config.self, config.technique.authority),
      reporter_(scene, config.self, config.technique),
      predictor_(scene, config.slots, config.self, config.technique),
      threshold_(config.technique),
      shown_(config.technique.convergence, scene, config.slots),
      roster_(roster_of(config)),
      links_(static_cast<std::size_t>(config.slots)),
      joined_(true) {
  assert(config.peers <= config.slots && config.self < config.peers);
  roster_.member = true;
  for (PeerId p = 0; p < config.peers; ++p) roster_.seats[p].presence = Presence::kThere;
  if (config.sign) reporter_.limit_bodies(sync::kMaxBodiesPerSigned);
  shown_.begin(live_.world().kinematics());
  refresh_own();
}

Replica::Replica(const Scene& scene, const ReplicaConfig& config, const sync::Transfer& start,
                 ConfirmedSink on_confirmed, Later)
    : scene_(scene),
      config_(config),
      agreed_(scene, config.agreed(), start, check_and(std::move(on_confirmed))),
      live_(scene, agreed_.predicted_state(), config.self, config.technique.authority),
      reporter_(scene, config.self, config.technique),
      predictor_(scene, config.slots, config.self, config.technique),
      threshold_(config.technique),
      shown_(config.technique.convergence, scene, config.slots),
      roster_(roster_of(config)),
      links_(static_cast<std::size_t>(config.slots)) {
  assert(config.self < config.slots);
  if (config.sign) reporter_.limit_bodies(sync::kMaxBodiesPerSigned);
  shown_.begin(live_.world().kinematics());
}

// The steps of the paper's Figure 5: sample input, apply received updates, step, predict, adapt the threshold, contacts
// -> update, test the model error, update if it is exceeded. The paper predicts after the contacts, and only without
// one.
void Replica::step(Vec2 target) {
  if (agreed_.catch_up()) adopt();
  if (jolt_ != Vec2{} && joined_) live_.jolt(std::exchange(jolt_, {}));
  const Vec2 velocity_before = live_.world().velocity(live_.avatar());
  if (!playing()) target = live_.world().position(live_.avatar());
  agreed_.step();
  note_time();
  live_.step(target, agreed_.predicted_state());
  go_on(target, velocity_before);
}

void Replica::step_led(const BodyState& from, const BodyState& to, Vec2 target) {
  if (agreed_.catch_up()) adopt();
  BodyState way = from;
  way.velocity = (to.position - from.position) * static_cast<float>(kTicksPerSecond);
  way.awake = from.awake || to.awake;
  live_.place(way);
  agreed_.step();
  note_time();
  live_.step_led(agreed_.predicted_state());
  reaction_ = live_.world().velocity(live_.avatar()) - way.velocity;
  live_.place(to);
  go_on(target, from.velocity);
}

void Replica::go_on(Vec2 target, Vec2 velocity_before) {
  if (member() && now() > roster_.in_since && !gone_ && !publish_order()) report(target, velocity_before);
  adopt(!agreed_.catch_up());
  shown_.advance(live_.world(), own_);
  agreed_.confirm();
  settle_checks();
  send();
  through_ticks_ = gone_ && all_through() ? through_ticks_ + 1 : 0;
}

void Replica::adopt(bool as_stepped) {
  refresh_own();
  const std::vector<bool>& kept = kept_from_live();
  const bool same = own_is_predicted(kept);
  live_.adopt(agreed_.predicted_state(), same ? own_ : kept, same, as_stepped);
  joined_ = member();
  for (const sync::LiveWorld::Jump& j : live_.jumps()) shown_.correct(j.entity, j.from);
}

// A slot that another body has come into keeps nothing of its former content. A state that was published rounded counts
// as it was published.
const std::vector<bool>& Replica::kept_from_live() {
  kept_ = own_;
  if (config_.technique.authority && config_.technique.unowned == Unowned::kLive && member()) {
    for (const EntityId b : unowned_.kept(agreed_.predicted_state(), live_.world(), config_.self)) kept_[b] = true;
  } else {
    unowned_.reset();
  }
  if (config_.technique.precision == Precision::kRounded && !own_log_.empty() && own_log_.back().tick == now())
    for (const sync::BodyUpdate& u : own_log_.back().bodies)
      if (u.has_state && u.state != live_.world().state(u.body)) kept_[u.body] = false;
  const std::vector<sync::Resident>& predicted = agreed_.predicted_state().residents.slots;
  for (EntityId b = 0; b < predicted.size(); ++b)
    if (live_.residents().slots[b] != predicted[b]) kept_[b] = false;
  return kept_;
}

// If the own entities are as predicted, the memory of their contacts may be, too: then live and predicted are the same,
// and drift apart only when something new happens here.
bool Replica::own_is_predicted(const std::vector<bool>& own) const {
  const sync::FoldState& p = agreed_.predicted_state();
  for (const EntityId e : mine_) {
    if (!own[e]) continue;
    const world::Kinematics& k = p.world.entities[e];
    if (live_.world().state(e) != BodyState{k.position, k.angle, k.velocity, k.spin, k.awake}) return false;
  }
  for (const EntityId b : unowned_.kept())
    if (own[b]) return false;
  return config_.technique.authority;
}

void Replica::refresh_own() {
  const sync::FoldState& p = agreed_.predicted_state();
  own_.assign(static_cast<std::size_t>(live_.world().entities()), false);
  mine_.clear();
  for (std::size_t b = 0; b < p.authority.size(); ++b)
    if (!config_.technique.authority || p.authority[b].holder() == config_.self)
      mine_.push_back(static_cast<EntityId>(b));
  if (joined_ && !gone_) mine_.push_back(live_.avatar());
  for (const EntityId e : mine_) own_[e] = true;
}

void Replica::report(Vec2 target, Vec2 velocity_before) {
  if (roster_.leaving && orders_.empty()) {
    sync::Bundle last;
    last.peer = config_.self;
    last.tick = now();
    last.leave = true;
    gone_ = true;
    ++stats_.updates_by_cause[static_cast<std::size_t>(sync::Cause::kLeave)];
    publish(last);
    return;
  }
  if (config_.spectates) return report_as_spectator();
  sync::Reporter::Situation s;
  s.live = &live_;
  s.predicted = &agreed_.predicted_state();
  s.target = target;
  s.acceleration = (live_.world().velocity(live_.avatar()) - velocity_before) * static_cast<float>(kTicksPerSecond);
  reporter_.watch_avatar(s);
  std::uint32_t everyone = own_end();
  bool full = false;
  double ahead = 0;
  for (PeerId p = 0; p < config_.slots; ++p) {
    if (p == config_.self || !seat(p).there()) continue;
    s.round_trip = std::max(s.round_trip, static_cast<Tick>(links_[p].out.round_trip()) + 1);
    everyone = std::min(everyone, links_[p].out.acked());
    if (links_[p].out.unanswered(now()) >= kGone) continue;
    sync::LinkRate& rate = links_[p].out.rate();
    full = full || !rate.may_tell(now());
    ahead = std::max(ahead, rate.ahead(now()));
  }
  price_ = config_.technique.budget > 0 ? sync::price_of(ahead) : 1;
  look_ahead(target);
  s.threshold = threshold();
  s.price = price_;
  s.may_tell = !full || now() - told_in_full_ >= kHeldBack;
  if (s.may_tell) told_in_full_ = now();
  const bool all = everyone >= own_first_ + own_log_.size();
  s.everyone_has = all ? now() - 1
                       : (everyone > own_first_ ? own_log_[everyone - own_first_ - 1].tick
                                                : (own_log_.empty() ? now() - 1 : own_log_.front().tick - 1));
  s.pushed = push_bodies();
  const sync::Bundle& bundle = reporter_.report(s);
  forget_pushes(bundle);
  live_.settle(bundle);
  take_on_rounded(bundle);
  if (bundle.avatar) ++stats_.updates_by_cause[static_cast<std::size_t>(bundle.avatar->cause)];
  for (const sync::BodyUpdate& u : bundle.bodies) ++stats_.updates_by_cause[static_cast<std::size_t>(u.cause)];
  if (bundle.avatar || !bundle.bodies.empty()) {
    publish(bundle);
  } else {
    publish_heartbeat();
  }
}

// A founder has an avatar until it says that it spectates.
void Replica::report_as_spectator() {
  if (agreed_.predicted_state().spectates(config_.self)) return publish_heartbeat();
  sync::Bundle last;
  last.peer = config_.self;
  last.tick = now();
  last.spectates = true;
  publish(last);
}

// The avatar is where its owner has published it. Bodies follow when the predicted state is adopted.
void Replica::take_on_rounded(const sync::Bundle& told) {
  if (config_.technique.precision != Precision::kRounded || !told.avatar || !told.avatar->awake) return;
  BodyState s = live_.world().state(live_.avatar());
  if (s.position == told.avatar->position && s.velocity == told.avatar->velocity) return;
  s.position = told.avatar->position;
  s.velocity = told.avatar->velocity;
  live_.place(s);
}

// The paper predicts at every turn of its loop in which no contact begins or ends; its techniques here do so every
// kLookEvery ticks, with or without one. Other techniques look ahead at most as often, and only if the result decides
// whether an update goes out: an avatar whose model is right within the low threshold may be as near to bodies as it
// likes.
void Replica::look_ahead(Vec2 target) {
  const bool always = config_.technique.update_every_contact;
  if (always ? now() % kLookEvery == 0 : now() - looked_ >= kLookEvery) {
    const bool look = always || reporter_.depends_on_threshold(coarseness_, price_);
    prediction_ = look ? predictor_.predict(live_.world(), target, agreed_.predicted_state()) : sync::Prediction{};
    if (look) looked_ = now();
  }
  threshold_.adapt(prediction_, reporter_.holding(), now());
}

void Replica::retune(const Technique& technique) {
  assert(technique.authority == config_.technique.authority);
  const bool other_world = technique.replay != config_.technique.replay;
  config_.technique = technique;
  reporter_.retune(technique);
  predictor_.retune(technique);
  threshold_.retune(technique);
  shown_.retune(technique.convergence, live_.world().kinematics());
  agreed_.set_replay(technique.replay);
  agreed_.set_time_stamps(technique.time_stamps);
  if (other_world) adopt();
}

bool Replica::may_push(EntityId b) const {
  if (!member() || config_.spectates || gone_ || roster_.leaving || !playing() || b >= live_.world().bodies())
    return false;
  return !config_.technique.authority || reporter_.may_change(agreed_.predicted_state(), b);
}

std::vector<EntityId> Replica::push_bodies() {
  std::vector<EntityId> pushed;
  std::erase_if(pushes_, [this](const auto& push) { return !may_push(push.first); });
  for (const auto& [b, velocity] : pushes_) {
    live_.push(b, velocity);
    pushed.push_back(b);
  }
  return pushed;
}

// A pushed body that did not fit the bundle and is not owned yet is reset to its predicted state, and has to be pushed
// again. With Unowned::kLive it is not reset, and only waits to be published.
void Replica::forget_pushes(const sync::Bundle& told) {
  std::erase_if(pushes_, [&](const auto& push) {
    const auto is_it = [&push](const sync::BodyUpdate& u) { return u.body == push.first && u.has_state; };
    return own_[push.first] || std::any_of(told.bodies.begin(), told.bodies.end(), is_it);
  });
  if (config_.technique.unowned == Unowned::kLive)
    for (auto& [b, velocity] : pushes_) velocity = {};
}

void Replica::publish(const sync::Bundle& bundle) {
  sync::Bundle own = own_pool_.copy(bundle);
  own.index = own_end();
  if (config_.sign) own.signature = config_.sign(own);
  ++stats_.bundles;
  file(own);
  own_log_.push_back(std::move(own));
}

bool Replica::publish_order() {
  if (orders_.empty()) return false;
  sync::Bundle bundle = std::move(orders_.front());
  orders_.pop_front();
  bundle.peer = config_.self;
  bundle.tick = now();
  publish(bundle);
  return true;
}

std::optional<sync::Signature> Replica::signed_now() const {
  if (own_log_.empty() || own_log_.back().tick != now()) return std::nullopt;
  return own_log_.back().signature;
}

float Replica::own_error() const {
  const sync::FoldState& predicted = agreed_.predicted_state();
  float sum = 0;
  for (const EntityId e : mine_) sum += distance(live_.world().position(e), predicted.world.entities[e].position);
  return sum;
}

std::uint64_t Replica::live_hash() const {
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
