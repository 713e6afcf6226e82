#include "common/wire/update_codec.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>
#include <span>

#include "common/wire/endpoint_codec.h"
#include "common/wire/passage_codec.h"
#include "common/wire/value_column.h"
#include "proto/wire.pb.h"

namespace padr::wire {
namespace {

using sync::AvatarUpdate;
using sync::BodyUpdate;
using sync::Bundle;

constexpr unsigned kAvatarAwake = 1U << 5U;
constexpr unsigned kAvatarSet = 1U << 6U;
constexpr unsigned kHeld = 1U << 3U;
constexpr unsigned kState = 1U << 4U;
constexpr unsigned kRelease = 1U << 5U;
constexpr unsigned kBodyAwake = 1U << 6U;
constexpr unsigned kFlagsEnd = 1U << 7U;
/// What an id left out counts for beside a body's flags.
constexpr unsigned kGap = kFlagsEnd;

bool has_control(Model m) {
  return m == Model::kSecond || m == Model::kInput;
}

void put_avatar(const AvatarUpdate& u, Update& out) {
  out.set_avatar(static_cast<unsigned>(u.cause) | static_cast<unsigned>(u.model) << 3U | (u.awake ? kAvatarAwake : 0) |
                 kAvatarSet);
}

/// `next`: the lowest id that it may have.
void put_body(const BodyUpdate& u, unsigned next, Tick tick, Update& out) {
  assert(u.body >= next);
  out.add_bodies((u.body - next) * kGap | static_cast<unsigned>(u.cause) | (u.held ? kHeld : 0) |
                 (u.has_state ? kState : 0) | (u.release ? kRelease : 0) |
                 (u.has_state && u.state.awake ? kBodyAwake : 0));
  if (!u.has_state) return;
  out.add_bodies(u.epoch);
  out.add_bodies(static_cast<std::uint32_t>(tick - u.claimed));
}

/// Reads the columns side by side, to their ends.
class Columns {
 public:
  Columns(const Update& in, Tick tick) : in_(in), tick_(tick), values_(in) {}

  bool take_avatar(AvatarUpdate& u) {
    const unsigned flags = in_.avatar();
    const unsigned cause = flags & 7U;
    if (flags >= kFlagsEnd || (flags & kAvatarSet) == 0 || cause >= sync::kCauses) return false;
    u.cause = static_cast<sync::Cause>(cause);
    u.model = static_cast<Model>((flags >> 3U) & 3U);
    u.awake = (flags & kAvatarAwake) != 0;
    const bool control = has_control(u.model);
    if (values_.left() < (control ? 6 : 4)) return false;
    u.position = values_.next_vec(kPlaceStep);
    u.velocity = values_.next_vec(kMotionStep);
    if (control) u.control = values_.next_vec(u.model == Model::kInput ? kPlaceStep : kMotionStep);
    return true;
  }
  bool more_bodies() const { return at_ < in_.bodies_size(); }
  bool take_body(BodyUpdate& u) {
    const std::uint32_t head = in_.bodies(at_++);
    const unsigned flags = head % kGap;
    next_id_ += head / kGap;
    if (next_id_ >= kNoEntity || (flags & 7U) >= sync::kCauses) return false;
    u.body = static_cast<EntityId>(next_id_++);
    u.cause = static_cast<sync::Cause>(flags & 7U);
    u.held = (flags & kHeld) != 0;
    u.has_state = (flags & kState) != 0;
    u.release = (flags & kRelease) != 0;
    const bool awake = (flags & kBodyAwake) != 0;
    if (!u.has_state) return !awake;
    u.state.awake = awake;
    return take_claim(u) && values_.take(u.state);
  }
  bool used_up() const { return !more_bodies() && values_.used_up(); }

 private:
  bool take_claim(BodyUpdate& u) {
    if (in_.bodies_size() - at_ < 2) return false;
    u.epoch = in_.bodies(at_++);
    const std::uint32_t age = in_.bodies(at_++);
    if (age > static_cast<std::uint32_t>(tick_)) return false;
    u.claimed = tick_ - static_cast<Tick>(age);
    return true;
  }

  const Update& in_;
  Tick tick_;
  ValueColumn<Update> values_;
  int at_ = 0;
  std::uint32_t next_id_ = 0;
};

bool take_entities(const Update& in, std::size_t most_bodies, Bundle& out) {
  Columns columns(in, out.tick);
  if (in.avatar() != 0 && !columns.take_avatar(out.avatar.emplace())) return false;
  while (columns.more_bodies())
    if (out.bodies.size() == most_bodies || !columns.take_body(out.bodies.emplace_back())) return false;
  return columns.used_up();
}

void put_orders(const Bundle& b, Update& out) {
  if (b.admission) {
    Admission& a = *out.mutable_admission();
    a.set_slot(b.admission->slot);
    a.set_incarnation(b.admission->incarnation);
    a.set_first(b.admission->first);
    put_endpoint(b.admission->at, a);
    for (const std::uint32_t have : b.admission->have) a.add_have(have);
    a.set_spectator(b.admission->spectator);
  }
  for (const sync::Removal& r : b.removals) {
    Removal& to = *out.add_removals();
    to.set_slot(r.slot);
    to.set_incarnation(r.incarnation);
    to.set_count(r.count);
  }
  for (const Bundle& lost : b.passed_on) {
    PassedOn& p = *out.mutable_passed_on();
    p.set_slot(lost.peer);
    p.set_index(lost.index);
    p.set_tick(static_cast<std::uint32_t>(lost.tick));
    put_update(lost, lost.tick, lost.index + 1, *p.mutable_update());
  }
}

bool take_within(const Update& in, Tick mark_tick, std::uint32_t mark_count, int depth, Bundle& out);

bool take_orders(const Update& in, int depth, Bundle& out) {
  if (in.has_admission()) {
    const Admission& a = in.admission();
    sync::Admission& to = out.admission.emplace();
    if (a.slot() >= kMaxPeers || a.have_size() > kMaxPeers || !take_endpoint(a, to.at)) return false;
    to.slot = static_cast<PeerId>(a.slot());
    to.incarnation = a.incarnation();
    to.first = a.first();
    to.have.assign(a.have().begin(), a.have().end());
    to.spectator = a.spectator();
  }
  for (const Removal& r : in.removals()) {
    if (r.slot() >= kMaxPeers || (!out.removals.empty() && r.slot() <= out.removals.back().slot)) return false;
    out.removals.push_back({static_cast<PeerId>(r.slot()), r.incarnation(), r.count()});
  }
  if (!in.has_passed_on()) return true;
  const PassedOn& p = in.passed_on();
  constexpr auto kMaxTick = static_cast<std::uint32_t>(std::numeric_limits<Tick>::max());
  if (depth == sync::kMaxPassing || p.slot() >= kMaxPeers || p.tick() >= kMaxTick || p.index() == 0xFFFFFFFFU)
    return false;
  Bundle& lost = out.passed_on.emplace_back();
  lost.peer = static_cast<PeerId>(p.slot());
  return take_within(p.update(), static_cast<Tick>(p.tick()), p.index() + 1, depth + 1, lost);
}

/// A farewell, an order of the coordinator's and what is told of entities are updates of their own each.
bool is_of_one_sort(const Update& in) {
  const std::array<bool, 8> sorts{
      in.leave(),         in.spectates(),         in.has_admission(), in.removals_size() > 0,
      in.has_passed_on(), in.passages_size() > 0, in.going() != 0,    in.avatar() != 0 || in.bodies_size() > 0};
  return std::count(sorts.begin(), sorts.end(), true) <= 1;
}

void clear(Bundle& b) {
  b.leave = false;
  b.spectates = false;
  b.avatar.reset();
  b.bodies.clear();
  b.admission.reset();
  b.removals.clear();
  b.passed_on.clear();
  b.going.reset();
  b.passages.clear();
  b.signature.reset();
}

bool take_within(const Update& in, Tick mark_tick, std::uint32_t mark_count, int depth, Bundle& out) {
  clear(out);
  if (!is_of_one_sort(in)) return false;
  if (in.index_back() >= mark_count) return false;
  if (in.tick_back() > static_cast<std::uint32_t>(mark_tick)) return false;
  out.index = mark_count - 1 - in.index_back();
  out.tick = mark_tick - static_cast<Tick>(in.tick_back());
  out.leave = in.leave();
  out.spectates = in.spectates();
  if (!in.signature().empty()) {
    if (in.signature().size() != sizeof(sync::Signature)) return false;
    const auto bytes = std::as_bytes(std::span(in.signature()));
    std::copy(bytes.begin(), bytes.end(), out.signature.emplace().begin());
  }
  const std::size_t most = out.signature ? sync::kMaxBodiesPerSigned : sync::kMaxBodiesPerBundle;
  return take_entities(in, most, out) && take_orders(in, depth, out) && take_passages(in, out);
}

}  // namespace

void put_update(const Bundle& b, Tick mark_tick, std::uint32_t mark_count, Update& out) {
  assert(b.index < mark_count && b.tick <= mark_tick);
  out.set_index_back(mark_count - 1 - b.index);
  out.set_tick_back(static_cast<std::uint32_t>(mark_tick - b.tick));
  out.set_leave(b.leave);
  out.set_spectates(b.spectates);
  if (b.avatar) put_avatar(*b.avatar, out);
  unsigned next = 0;
  for (const BodyUpdate& body : b.bodies) {
    put_body(body, next, b.tick, out);
    next = body.body + 1U;
  }
  put_values(b, out);
  put_orders(b, out);
  put_passages(b, out);
  if (b.signature) out.set_signature(b.signature->data(), b.signature->size());
}

bool take_update(const Update& in, Tick mark_tick, std::uint32_t mark_count, Bundle& out) {
  return take_within(in, mark_tick, mark_count, 0, out);
}

}  // namespace padr::wire
