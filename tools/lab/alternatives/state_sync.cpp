#include "tools/lab/alternatives/state_sync.h"

#include <algorithm>

#include "common/world/avatar_control.h"

namespace padr::lab::alternatives {
namespace {

constexpr int kPayloadPerSecond = 8000;  // bytes to each peer
constexpr Tick kIdle = 30;
constexpr int kNumberBits = 16;
constexpr int kAckBits = 32;
constexpr int kSequenceBits = 16;
constexpr int kBackBits = 6;  // of the datagram that a difference is to
constexpr std::size_t kReceivedKept = 1 << kBackBits;
constexpr float kHeldPriority = 10;
constexpr Tick kMostCarried = 60;
constexpr float kSameTarget = 0.001F;  // m
constexpr Fields kAvatarFields{.turns = false, .moves = true};
constexpr Fields kBodyFields{.turns = true, .moves = true};

}  // namespace

StateSync::StateSync(const Scene& scene, const AlternativeConfig& config)
    : Replica(scene, config),
      quantiser_(scene, config.spec.steps_per_m),
      id_bits_(width_of(static_cast<std::uint32_t>(std::max(1, world_.bodies())))),
      links_(static_cast<std::size_t>(config.peers)),
      avatar_tick_(static_cast<std::size_t>(config.peers), -1),
      body_tick_(static_cast<std::size_t>(world_.bodies())),
      resting_(static_cast<std::size_t>(world_.bodies())) {
  for (PeerId p = 0; p < peers(); ++p) targets_.push_back(world_.position(world_.avatar(p)));
  for (EntityId b = 0; b < world_.bodies(); ++b) initial_.push_back(quantiser_.quantise(world_.state(b)));
  for (Link& link : links_) {
    link.received.resize(static_cast<std::size_t>(world_.bodies()));
    link.priority.assign(static_cast<std::size_t>(world_.bodies()), 0);
    for (EntityId b = 0; b < world_.bodies(); ++b) link.acknowledged.push_back({b, 0, 0, false, initial_[b]});
  }
}

// --- receiving

void StateSync::carry_avatar(BodyState& s, Vec2 target, Tick ticks) const {
  const AvatarDef& def = world_.scene().avatar;
  for (Tick t = 0; t < ticks; ++t) {
    if (world::has_arrived(s.position, s.velocity, target)) return;
    const Vec2 force = world::control_force(def, s.position, s.velocity, target);
    s.velocity = s.velocity + force * (kTickSeconds / def.mass);
    s.position = s.position + s.velocity * kTickSeconds;
  }
}

// Without gravity: what lies on something does not fall, and what is in the air is soon corrected.
void StateSync::carry_body(BodyState& s, EntityId body, Tick ticks) const {
  const BodyDef& def = world_.scene().bodies[body];
  for (Tick t = 0; t < ticks && s.awake; ++t) {
    s.velocity = s.velocity * (1 / (1 + kTickSeconds * def.linear_damping));
    s.spin /= 1 + kTickSeconds * def.angular_damping;
    s.position = s.position + s.velocity * kTickSeconds;
    s.angle += s.spin * kTickSeconds;
  }
}

void StateSync::take_avatar(PeerId from, const BodyState& told, Vec2 target, Tick tick) {
  if (tick <= avatar_tick_[from]) return;
  avatar_tick_[from] = tick;
  targets_[from] = target;
  BodyState s = told;
  carry_avatar(s, target, std::clamp(now() - tick, 0, kMostCarried));
  world_.set_state(world_.avatar(from), s);
}

void StateSync::take_body(const Told& t, PeerId from, Tick tick) {
  if (!claims_.hear(t.entity, {from, t.sequence, t.held, t.state.awake})) return;
  Newest& newest = body_tick_[t.entity];
  if (newest.from == from && tick <= newest.tick) return;
  newest = {from, tick};
  resting_[t.entity].reset();
  BodyState s = quantiser_.state(t.state);
  carry_body(s, t.entity, std::clamp(now() - tick, 0, kMostCarried));
  if (!s.awake) resting_[t.entity] = s;
  world_.set_state(t.entity, s);
}

/// False: has been here, or is older than can be told.
bool StateSync::note(Link& link, std::uint16_t number) const {
  const auto ahead = static_cast<std::int16_t>(static_cast<std::uint16_t>(number - link.newest));
  if (!link.heard || ahead > 0) {
    const int shift = link.heard ? ahead : kAckBits;
    link.before_newest = shift >= kAckBits ? 0 : link.before_newest << static_cast<unsigned>(shift);
    if (link.heard && shift <= kAckBits) link.before_newest |= 1U << static_cast<unsigned>(shift - 1);
    link.newest = number;
    link.heard = true;
    return true;
  }
  if (ahead == 0 || -ahead > kAckBits) return false;
  const std::uint32_t bit = 1U << static_cast<unsigned>(-ahead - 1);
  if ((link.before_newest & bit) != 0) return false;
  link.before_newest |= bit;
  return true;
}

void StateSync::acknowledge(Link& link, std::uint16_t newest, std::uint32_t before) {
  const auto behind = [newest](const Sent& s) {
    return static_cast<std::int16_t>(static_cast<std::uint16_t>(newest - s.number));
  };
  const auto arrived = [&](const Sent& s) {
    const int back = behind(s);
    return back == 0 || (back > 0 && back <= kAckBits && ((before >> static_cast<unsigned>(back - 1)) & 1U) != 0);
  };
  // In the order of sending, so that the last one that has arrived stands.
  for (const Sent& s : link.sent) {
    if (!arrived(s)) continue;
    for (const Told& t : s.told) link.acknowledged[t.entity] = t;
  }
  std::erase_if(link.sent, [&](const Sent& s) { return behind(s) > kAckBits || arrived(s); });
}

bool StateSync::take(PeerId from, BitReader& r) {
  Link& link = links_[from];
  const auto number = static_cast<std::uint16_t>(r.get(kNumberBits));
  const Tick tick = whole_tick(r.get(kTickBits), now());
  const bool has_ack = r.flag();
  const auto newest = static_cast<std::uint16_t>(has_ack ? r.get(kNumberBits) : 0);
  const std::uint32_t before = has_ack ? r.get(kAckBits) : 0;
  const BodyState avatar = quantiser_.state(quantiser_.read(r, {}, kAvatarFields));
  const Vec2 target = quantiser_.read_point(r);
  if (!r.ok() || !note(link, number)) return false;
  if (has_ack) acknowledge(link, newest, before);
  take_avatar(from, avatar, target, tick);
  const std::uint32_t count = r.get_small();
  for (std::uint32_t i = 0; i < count; ++i) {
    Told t;
    t.number = number;
    if (!read(r, t, link)) return false;
    take_body(t, from, tick);
    link.owes_ack = true;
  }
  return r.ok();
}

bool StateSync::read(BitReader& r, Told& t, Link& link) const {
  t.entity = static_cast<EntityId>(r.get(id_bits_));
  if (!r.ok() || t.entity >= world_.bodies()) return false;
  std::deque<Told>& received = link.received[t.entity];
  Told base;
  const bool based = r.flag();
  if (based) {
    const auto number = static_cast<std::uint16_t>(t.number - r.get(kBackBits));
    const auto found =
        std::find_if(received.begin(), received.end(), [number](const Told& o) { return o.number == number; });
    if (found == received.end()) return false;
    base = *found;
  }
  const bool same_claim = based && r.flag();
  t.sequence = same_claim ? base.sequence : static_cast<std::uint16_t>(r.get(kSequenceBits));
  t.held = r.flag();
  t.state = quantiser_.read(r, base.state, kBodyFields);
  if (!r.ok()) return false;
  received.push_back(t);
  if (received.size() > kReceivedKept) received.pop_front();
  return true;
}

// --- simulating

void StateSync::before_step() {
  for (PeerId p = 0; p < peers(); ++p)
    if (p != self()) world::drive_avatar(world_, p, targets_[p]);
}

// What rests in its owner's world does so here too, whatever runs into it in ours: the owner has nothing to tell that
// would put it back.
void StateSync::place_others() {
  for (EntityId b = 0; b < world_.bodies(); ++b)
    if (!claims_.mine(b) && resting_[b]) world_.set_state(b, *resting_[b]);
}

// --- sending

StateSync::Told StateSync::present(EntityId e) const {
  return {e, 0, claims_.of(e).sequence, claims_.of(e).held, quantiser_.quantise(world_.state(e))};
}

bool StateSync::is_acknowledged(const Link& link, EntityId body) const {
  const Told here = present(body);
  const Told& there = link.acknowledged[body];
  return there.sequence == here.sequence && there.held == here.held && there.state == here.state;
}

/// Bodies that have something to tell, the most urgent first.
std::vector<EntityId> StateSync::ranked(Link& link) const {
  std::vector<EntityId> bodies;
  for (EntityId b = 0; b < world_.bodies(); ++b) {
    if (!claims_.mine(b) || is_acknowledged(link, b)) {
      link.priority[b] = 0;
      continue;
    }
    link.priority[b] += claims_.of(b).held ? kHeldPriority : 1;
    bodies.push_back(b);
  }
  std::stable_sort(bodies.begin(), bodies.end(),
                   [&link](EntityId a, EntityId b) { return link.priority[a] > link.priority[b]; });
  return bodies;
}

bool StateSync::idle(const Link& link, bool nothing) const {
  return nothing && !link.owes_ack && !world_.awake(avatar()) && distance(target(), link.target_told) < kSameTarget &&
         now() - link.sent_at < kIdle;
}

void StateSync::write_header(BitWriter& w, const Link& link) const {
  w.put(link.next, kNumberBits);
  w.put(static_cast<std::uint32_t>(now()) & 0xFFFFU, kTickBits);
  w.flag(link.heard);
  if (link.heard) {
    w.put(link.newest, kNumberBits);
    w.put(link.before_newest, kAckBits);
  }
  quantiser_.write(w, quantiser_.quantise(world_.state(avatar())), {}, kAvatarFields);
  quantiser_.write_point(w, target());
}

void StateSync::write(BitWriter& w, const Told& t, const Told& base) const {
  w.put(t.entity, id_bits_);
  const auto back = static_cast<std::uint16_t>(t.number - base.number);
  const bool based = base.number != 0 && back < (1 << kBackBits);
  w.flag(based);
  if (based) {
    w.put(back, kBackBits);
    w.flag(base.sequence == t.sequence);
  }
  if (!based || base.sequence != t.sequence) w.put(t.sequence, kSequenceBits);
  w.flag(t.held);
  quantiser_.write(w, t.state, based ? base.state : Quantised{}, kBodyFields);
}

void StateSync::send_to(PeerId to) {
  Link& link = links_[to];
  const std::vector<EntityId> bodies = ranked(link);
  if (idle(link, bodies.empty())) return;
  const std::size_t budget =
      std::min<std::size_t>(wire::kMaxPayload, static_cast<std::size_t>(kPayloadPerSecond / spec().hz)) * 8;
  BitWriter header;
  write_header(header, link);
  BitWriter states;
  Sent sent{link.next, {}};
  if (++link.next == 0) link.next = 1;  // 0 stands for none
  constexpr std::size_t kCountBits = 12;
  for (const EntityId b : bodies) {
    BitWriter one;
    Told t = present(b);
    t.number = sent.number;
    write(one, t, link.acknowledged[b]);
    if (header.bits() + kCountBits + states.bits() + one.bits() > budget) break;
    states.append(one);
    link.priority[b] = 0;
    sent.told.push_back(t);
  }
  header.put_small(static_cast<std::uint32_t>(sent.told.size()));
  header.append(states);
  link.target_told = target();
  link.sent_at = now();
  link.owes_ack = false;
  post(to, header, sent.told.size() + 1);
  link.sent.push_back(std::move(sent));
}

void StateSync::send() {
  const bool due = now() * spec().hz / kTicksPerSecond != (now() - 1) * spec().hz / kTicksPerSecond;
  if (!due) return;
  for (PeerId p = 0; p < peers(); ++p)
    if (p != self()) send_to(p);
}

}  // namespace padr::lab::alternatives
