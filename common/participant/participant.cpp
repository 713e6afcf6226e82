#include "common/participant/participant.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "common/membership/last_heard.h"
#include "common/model/rng.h"
#include "common/model/user_error.h"
#include "common/sync/validation.h"
#include "common/wire/signature.h"
#include "common/world/fingerprint.h"

namespace padr::node {
namespace {

/// Interval between corrections of the clock; the correction itself is measured over seconds.
constexpr Tick kSteerEvery = kTicksPerSecond / 2;
/// When all peers are stopped at once, this many leave in one tick, because every peer answers every leave update.
constexpr int kFarewells = 4;
/// Most bytes of others that are passed on at once.
constexpr double kCarriedAtOnce = 64'000;
/// The same for newcomers, between which and the coordinator this peer carries; they take nothing from members.
constexpr double kIntroducedAtLeast = 16'000;
constexpr double kIntroducedAtOnce = 64'000;
/// Interval between two times of telling members for whom this peer carries where it sees them.
constexpr Micros kIntroduceAgain = 3 * kMicrosPerSecond;
/// Interval between two events about datagrams that do not fit the session's key.
constexpr Micros kWarnAgain = 10 * kMicrosPerSecond;
/// Time in which whoever sent one may yet turn out to be a member.
constexpr Micros kGrace = kMicrosPerSecond;

/// Throws UserError for a session that cannot be founded in this scene.
void check_founder(const SessionConfig& c, const Scene& scene) {
  const auto most = std::min<std::size_t>(scene.avatar.spawns.size(), kMaxPeers);
  if (c.slots < 1 || static_cast<std::size_t>(c.slots) > most)
    throw UserError("slots: " + std::to_string(c.slots) + " is not allowed; give 1 to " + std::to_string(most) +
                    ", the scenario's places to start from");
  const int room = c.slots - (c.spectates ? 1 : 0);
  if (c.wanted < 1 || c.wanted > room)
    throw UserError("wanted: " + std::to_string(c.wanted) + " is not allowed; give 1 to " + std::to_string(room) +
                    ", the slots for players");
}

void check(const Technique& t) {
  if (const std::string wrong = wrong_field(t); !wrong.empty()) throw UserError("technique." + wrong);
}

}  // namespace

Participant::Participant(const Scene& scene, ParticipantConfig config, Micros local)
    : scene_(scene),
      config_(std::move(config)),
      local_(local),
      warned_(local - kWarnAgain),
      began_(local),
      for_members_(config_.carries, kCarriedAtOnce, 0, local),
      for_newcomers_(kIntroducedAtLeast, kIntroducedAtOnce, kIntroducedAtOnce, local),
      introduced_(local) {
  check(config_.replica.technique);
  if (config_.channels) {
    auto& may = config_.channels->may_carry;
    if (!may) may = [this](const auto& from, const auto& to, auto bytes) { return may_carry(from, to, bytes); };
    channels_.emplace(*config_.channels);
  }
  SessionConfig& session = config_.session;
  if (!session.join) check_founder(session, scene_);
  session.sealed = channels_.has_value();
  session.scene_hash = scene_hash(scene_);
  if (channels_ && !session.join)
    session.id = wire::session_id(config_.channels->seed, channels_->key(), session.scene_hash);
  // The channels have what they need.
  if (channels_) config_.channels->session = config_.channels->seed = {};
  session.authority = config_.replica.technique.authority;
  if (session.fingerprint == 0) session.fingerprint = world::physics_fingerprint();
  next_.session = std::make_unique<Session>(config_.session, local);
}

Participant::~Participant() = default;

void Participant::receive(const Endpoint& from, std::span<const std::byte> datagram, Micros local) {
  local_ = local;
  if (!channels_) return take({from, datagram}, local);
  const auto arrival = channels_->receive(from, datagram, local);
  warn_of_last_key();
  for (const Endpoint& at : channels_->take_readable())
    events_.push_back({.kind = SessionEvent::Kind::kReadable, .at = at});
  if (arrival) return take(*arrival, local);
  warn_of_drops(from, local);
}

// A peer with a wrong key, or none, keeps trying: an event tells why it gets no answer. Where this peer's process has
// begun anew, members send what is for the one before until they have met this one.
void Participant::warn_of_drops(const Endpoint& place, Micros local) {
  const auto& dropped = channels_->stats().dropped;
  const std::uint64_t drops =
      dropped[static_cast<std::size_t>(ChannelDrop::kUnsealed)] + dropped[static_cast<std::size_t>(ChannelDrop::kTag)];
  const std::uint64_t news = drops - std::exchange(drops_seen_, drops);
  if (channels_->hears(place, local)) {
    drops_told_ += news;
  } else if (news > 0) {
    dropped_at_ = place;
    if (!doubtful_) doubtful_ = local;
  }
  if (!doubtful_ || local - *doubtful_ < kGrace) return;
  if (channels_->hears(dropped_at_, local)) {
    drops_told_ = drops;
    doubtful_.reset();
  }
  if (drops == drops_told_ || local - warned_ < kWarnAgain) return;
  events_.push_back({.kind = SessionEvent::Kind::kWrongKey, .at = dropped_at_, .count = drops - drops_told_});
  drops_told_ = drops;
  warned_ = local;
}

void Participant::warn_of_last_key() {
  if (!channels_->has_told_all_keys() || std::exchange(last_key_told_, true)) return;
  events_.push_back({.kind = SessionEvent::Kind::kLastKeyLogged, .count = config_.channels->most_keys});
}

void Participant::post(const Endpoint& to, PeerId state_to, std::span<const std::byte> bytes) {
  if (!config_.tamper) return hand_over(to, state_to, bytes);
  for (const Parcel& p : config_.tamper({to, state_to, wire::Bytes(bytes.begin(), bytes.end())}))
    hand_over(p.to, p.state_to, p.bytes);
}

void Participant::hand_over(const Endpoint& to, PeerId state_to, std::span<const std::byte> bytes) {
  for_members_.add(bytes.size());
  if (channels_) return channels_->send(to, state_to, bytes, local_);
  outgoing_.add(to, state_to, bytes);
}

// Half of what this peer sends may be what it carries, and some more, so that quiet peers can carry, too.
bool Participant::may_carry(const Endpoint& from, const Endpoint& to, std::size_t bytes) {
  if (!current_.membership) return false;
  if (current_.membership->may_carry(from, to)) {
    carried_to_[current_.membership->member_at(to)] |= only(current_.membership->member_at(from));
    return for_members_.take(bytes, local_);
  }
  return current_.membership->may_introduce(from, to) && for_newcomers_.take(bytes, local_);
}

Micros Participant::lateness(Micros local) const {
  return current_.session->session_now(local) - tick_start(replica().now() + 1);
}

void Participant::note_sleep(Micros local) {
  if (current_.membership && lateness(local) > tick_start(kSilence)) current_.membership->note_sleep();
}

void Participant::take(const SecureChannels::Arrival& arrival, Micros local) {
  note_sleep(local);
  const auto& [from, datagram, carried] = arrival;
  wire::SealError refused{};
  std::uint8_t version = 0;
  const auto opened = wire::open(datagram, refused, &version);
  for (Incarnation* incarnation : {&current_, &next_}) {
    if (!incarnation->session) continue;
    if (!opened) {
      incarnation->session->on_refused(from, datagram.size(), refused, version, local);
      continue;
    }
    if (!incarnation->session->receive(from, *opened, local) || !incarnation->membership) continue;
    const PeerId peer = opened->header.sender;
    if (!incarnation->membership->hears(peer)) {
      incarnation->replica->count_drop(peer, sync::DropReason::kCutOff);
      continue;
    }
    if (!carried) incarnation->membership->note_direct(peer);
    const auto why = incarnation->replica->receive(*opened, incarnation->session->session_now(local));
    if (why == sync::DropReason::kNone) continue;
    if (why == sync::DropReason::kForeign) incarnation->membership->on_stranger(from, datagram.size(), local);
    // A peer that was held up finds all others ahead of it: that is no fault of theirs.
    const Tick due = incarnation->replica->replica().now() + 1;
    const bool behind = incarnation->session->session_now(local) - tick_start(due) > tick_start(kHeldUp);
    if (why != sync::DropReason::kTick || !behind) incarnation->membership->on_drop(peer, why, local);
  }
}

// Nothing proves where such a report comes from: it does not count in a session with a key.
void Participant::unreachable(const Endpoint& at, Micros local) {
  if (channels_) return;
  for (Incarnation* incarnation : {&current_, &next_})
    if (incarnation->session) incarnation->session->unreachable(at, local);
}

void Participant::advance(Micros local) {
  local_ = local;
  for (Incarnation* incarnation : {&current_, &next_})
    if (incarnation->session && local >= incarnation->session->next_due()) incarnation->session->advance(local);
  if (next_.session) bring_in_next(local);
  if (playing()) give_up_waiting(local);
  use_carriers();
  collect(current_);
  collect(next_);
}

Micros Participant::next_due() const {
  Micros due = std::numeric_limits<Micros>::max();
  for (const Incarnation* incarnation : {&current_, &next_})
    if (incarnation->session) due = std::min(due, incarnation->session->next_due());
  return due;
}

Micros Participant::next_step() const {
  return session().local_at(tick_start(replica().now() + 1));
}

bool Participant::step_due(Micros local) const {
  return playing() && local >= next_step() && (local != turn_ || steps_ < kStepsPerTurn);
}

void Participant::step(Vec2 target, Micros local) {
  const Micros lateness = before_step(local);
  played().step(usable(target), lateness);
  after_step(local);
}

void Participant::step_led(const BodyState& from, const BodyState& to, Vec2 target, Micros local) {
  before_step(local);
  played().step_led(from, to, usable(target));
  after_step(local);
}

// What the others do not believe they drop, with all else that the datagram tells.
Vec2 Participant::usable(Vec2 target) {
  if (!target_) target_ = replica().live().world().position(replica().live().avatar());
  if (is_finite(target)) target_ = sync::believable_target(target, scene_);
  return *target_;
}

Micros Participant::before_step(Micros local) {
  local_ = local;
  steps_ = local == turn_ ? steps_ + 1 : 1;
  turn_ = local;
  if (farewell_ && replica().now() >= *farewell_) say_goodbye();
  if (replica().playing()) current_.session->settle_clock();
  note_sleep(local);
  const Micros lateness = this->lateness(local);
  if (lateness > tick_start(kHeldUp)) current_.replica->excuse_tick();
  return lateness;
}

void Participant::after_step(Micros local) {
  current_.membership->advance(local);
  for (const Outgoing& o : current_.replica->outgoing()) post(replica().seat(o.to).at, o.to, o.bytes);
  look_for_way_back(local);
  use_carriers();
  collect(current_);
  collect(next_);
  if (!config_.steers || std::abs(replica().now() - steered_) < kSteerEvery) return;
  steered_ = replica().now();
  steer(local);
}

// The clock that counts is that of the most senior peer present. After its machine was suspended, a peer would be
// steered for minutes, and all confirmed worlds would wait for it.
void Participant::steer(Micros local) {
  if (std::abs(replica().now() - skipped_) < kClocksShowOf) return current_.session->steer(local, 0);
  if (const Micros lag = replica().least_clock_lag(); lag >= Replica::kFarBehind) {
    skipped_ = replica().now();
    return current_.session->skip(local, lag);
  }
  const PeerId first = replica().most_senior_other();
  const bool follows = first != kNoPeer && replica().roster().is_senior(first, replica().self());
  current_.session->steer(local, follows ? replica().clock_lead() : 0);
}

PeerId Participant::coordinator() const {
  assert(playing());
  return current_.membership->coordinator();
}

void Participant::push(EntityId b, Vec2 velocity) {
  if (b >= replica().live().world().bodies())
    throw UserError("body: " + std::to_string(b) + " is not allowed; the scene has " +
                    std::to_string(replica().live().world().bodies()) + " bodies, numbered from 0");
  constexpr float kMost = trace::Push::kMost;
  if (!(std::abs(velocity.x) <= kMost && std::abs(velocity.y) <= kMost))
    throw UserError("velocity: " + std::to_string(velocity.x) + ", " + std::to_string(velocity.y) +
                    " is not allowed; give at most 1000 m/s in x and in y");
  played().push(b, velocity);
}

void Participant::retune(const Technique& technique) {
  check(technique);
  if (technique.authority != config_.replica.technique.authority)
    throw UserError("technique.authority: is the session's rule, and must stay as it is");
  config_.replica.technique = technique;
  for (Incarnation* incarnation : {&current_, &next_})
    if (incarnation->replica) incarnation->replica->retune(technique);
}

void Participant::knock(const Endpoint& at) {
  if (current_.membership) current_.membership->knock(at);
}

void Participant::leave(Micros local, bool stay) {
  if (left_at_) return;
  left_at_ = local;
  stays_ = stay;
  if (!playing()) return;
  next_ = {};
  plan_farewell();
}

void Participant::plan_farewell() {
  farewell_ = replica().now() + replica().self() / kFarewells;
}

void Participant::say_goodbye() {
  current_.replica->leave();
  farewell_.reset();
}

// A peer that vanished acknowledges nothing, but is removed before long.
bool Participant::done(Micros local) const {
  if (!left_at_) return false;
  if (!playing()) return true;  // nobody knows it yet
  const bool waited = local - *left_at_ >= config_.linger;
  if (nobody_to_tell() && replica().orders() == 0) return local > *left_at_;
  if (farewell_) return false;
  const int others = session().players() - (config_.session.spectates ? 0 : 1);
  return waited || (replica().delivered() && !(stays_ && others > 0));
}

bool Participant::nobody_to_tell() const {
  for (PeerId p = 0; p < replica().config().slots; ++p)
    if (p != replica().self() && replica().seat(p).reachable()) return false;
  return true;
}

Endpoint Participant::place(PeerId p) const {
  const Endpoint& told = replica().seat(p).at;
  const Endpoint found = channels_ && told.has_key() ? channels_->place(told.key) : Endpoint{};
  return found.is_set() ? found : told.place();
}

// A newcomer asks through whoever has redirected it until something comes directly. The coordinator answers by the way
// that the newcomer comes: it may take the one and not the other.
void Participant::use_introductions() {
  for (const Incarnation* incarnation : {&current_, &next_}) {
    if (!incarnation->session) continue;
    const auto i = incarnation->session->introduction(local_);
    if (i && !channels_->came(i->to.key, local_).directly) channels_->carry(i->to.key, i->by.key, true, local_);
  }
  if (!current_.membership) return;
  for (const Introductions::Introduction& i : current_.membership->introduced()) {
    channels_->expect(i.newcomer, i.since, local_);
    const auto came = channels_->came(i.newcomer.key, local_);
    if (came.carried) channels_->carry(i.newcomer.key, i.other.key, came.directly, local_);
  }
}

// Only for so long as it is said again and again.
void Participant::use_carriers() {
  if (!channels_) return;
  use_introductions();
  if (!current_.membership) return;
  const Membership& m = *current_.membership;
  for (PeerId p = 0; p < replica().config().slots; ++p)
    if (const PeerId by = m.carrier(p); by != kNoPeer)
      channels_->carry(replica().seat(p).at.key, replica().seat(by).at.key, m.is_unsure_of(p), local_, m.addresses(p));
  introduce_carried();
}

// Of two that have moved at the same moment each sends to where the other one was. Whoever carries between them knows.
void Participant::introduce_carried() {
  if (local_ - introduced_ < kIntroduceAgain) return;
  introduced_ = local_;
  for (PeerId to = 0; to < session().slots(); ++to) {
    const PeerSet carried = std::exchange(carried_to_[to], 0);
    if (!replica().seat(to).reachable()) continue;  // it has gone since
    for (PeerId p = 0; p < session().slots(); ++p) {
      if ((carried & only(p)) == 0) continue;
      const Endpoint& who = replica().seat(p).at;
      if (!channels_->came(who.key, local_).directly) continue;
      Endpoint where = place(p);
      where.key = who.key;
      current_.membership->introduce(where, to);
    }
  }
}

void Participant::collect(Incarnation& incarnation) {
  if (!incarnation.session) return;
  for (const SessionDatagram& d : incarnation.session->take_outgoing()) post(d.to, kNoPeer, d.bytes);
  for (SessionEvent& e : incarnation.session->take_events())
    if (!left_at_ || e.kind != SessionEvent::Kind::kOutvoted) events_.push_back(std::move(e));  // it joins nobody
  if (!incarnation.membership) return;
  for (const MemberChange& c : incarnation.membership->take_changes()) changes_.push_back(c);
}

std::span<const Parcel> Participant::take_outgoing() {
  return channels_ ? channels_->take_outgoing() : outgoing_.take();
}

std::vector<SessionEvent> Participant::take_events() {
  return std::exchange(events_, {});
}

std::vector<MemberChange> Participant::take_changes() {
  return std::exchange(changes_, {});
}

void Participant::finish() {
  if (current_.replica) current_.replica->finish();
}

}  // namespace padr::node
