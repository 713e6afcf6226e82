#include "common/crowd/crowd_peer.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/model/rng.h"
#include "common/wire/seal.h"

namespace padr::crowd {
namespace {

/// Ticks between two looks at which regions to be in.
constexpr Tick kReconsider = 6;
/// Ticks between two looks at bodies that cross borders.
constexpr Tick kCustoms = 3;
/// Ticks between two corrections of the clocks.
constexpr Tick kSteer = kTicksPerSecond / 2;
/// States kept of every region, for rewinding: 4 s, half of what a session keeps, as a peer has several regions.
constexpr std::size_t kKeptTicks = 256;
constexpr Micros kRetry = 500'000;
constexpr Micros kPatience = 4 * kMicrosPerSecond;
/// Who leaves a region lingers at most so long to get its last words across.
constexpr Micros kLinger = 4 * kMicrosPerSecond;
/// Between two knocks at those who are in one of our regions on another side.
constexpr Micros kKnock = 400'000;
constexpr std::size_t kEventsKept = 256;
/// A keeper's avatar is told of no farther outside than this, m: what lies farther out is not believed.
constexpr float kFarthest = 16;

std::optional<std::uint16_t> session_of(std::span<const std::byte> datagram) {
  if (datagram.size() < wire::kHeaderBytes) return std::nullopt;
  return static_cast<std::uint16_t>(std::to_integer<unsigned>(datagram[4]) | std::to_integer<unsigned>(datagram[5])
                                                                                 << 8U);
}

BodyState held_near(const Plane& plane, Region r, BodyState s) {
  s.position = held_near(plane, r, s.position, kFarthest);
  return s;
}

/// What the avatar touches there, but is not in `home`: what is in both has its say there.
bool touches_only_strangers(const node::Replica& n, const node::Replica& home) {
  const EntityId avatar = n.live().avatar();
  const auto& here = n.live().residents();
  bool any = false;
  for (const Contact& c : n.live().touching()) {
    if (c.first != avatar && c.second != avatar) continue;
    const EntityId other = c.first == avatar ? c.second : c.first;
    if (n.live().world().is_avatar(other) || home.live().residents().find(here.slots[other].name)) return false;
    any = true;
  }
  return any;
}

/// The other members of a region, besides where they are.
void add_fellows(Region r, const node::Participant& p, Fellows& fellows) {
  const node::Replica& n = p.replica();
  for (PeerId other = 0; other < n.config().slots; ++other)
    if (other != n.self() && n.seat(other).there() && n.seat(other).at.is_set())
      fellows.emplace_back(n.seat(other).at.place(), r);
}

/// It wants to leave the region, and will if it can: not the one to come in by, as long as there are others.
bool only_waits_to_leave(const node::Replica& n) {
  const std::vector<sync::Member>& members = n.agreed().predicted_state().members;
  if (!members[n.self()].going) return false;
  for (PeerId p = 0; p < members.size(); ++p)
    if (p != n.self() && n.seat(p).there() && !members[p].going) return true;
  return false;
}

}  // namespace

CrowdPeer::CrowdPeer(const CrowdConfig& config)
    : config_(config),
      handover_(config.plane),
      finder_({config.plane, config.contact, derive_seed(config.seed, 0xF1)}) {
  avatar_.position = config.start;
  wanted_ = {region_at(config.plane, config.start)};
}

// ---- coming into regions

Standing CrowdPeer::standing(bool with_fellows, Micros local) const {
  Standing s;
  s.home = home_ ? *home_ : wanted_.front();
  if (home_) s.clock = places_.at(*home_).peer->session().session_now(local);
  for (const auto& [region, place] : places_) {
    const bool member = place.peer->playing() && place.peer->replica().member();
    const bool in = member && !place.peer->leaving();
    const bool founding = !place.by && !place.peer->playing();
    if (member && with_fellows) add_fellows(region, *place.peer, s.fellows);
    if (founding || (in && !only_waits_to_leave(place.peer->replica()))) s.in.push_back(region);
  }
  std::sort(s.fellows.begin(), s.fellows.end());
  s.fellows.erase(std::unique(s.fellows.begin(), s.fellows.end()), s.fellows.end());
  return s;
}

void CrowdPeer::find(Micros local) {
  if (leaving_ || local < finder_.next_due()) return;
  std::vector<Region> sought;
  for (const Region r : wanted_) {
    const auto retry = retry_.find(r);
    if (!places_.contains(r) && (retry == retry_.end() || retry->second <= local)) sought.push_back(r);
  }
  finder_.advance(standing(finder_.looks_about(sought, local), local), sought, local);
  for (const Finder::Finding& f : finder_.take_findings()) enter(f.region, f.member, local);
  if (local - knocked_ < kKnock) return;
  knocked_ = local;
  for (const auto& [region, at] : finder_.strangers(local)) places_.at(region).peer->knock(at);
}

void CrowdPeer::enter(Region r, const std::optional<Endpoint>& member, Micros local) {
  node::ParticipantConfig c;
  c.linger = kLinger;
  c.steers = false;  // a peer has one clock for all its regions
  const Scene scene = scene_of(config_.plane, r);
  c.session.join = member;
  c.session.wanted = 1;
  c.session.slots = config_.plane.slots;
  c.session.fingerprint = config_.fingerprint;
  c.session.scenario = scene.name;
  c.session.seed = derive_seed(config_.seed, ++attempts_);
  c.session.secret = config_.secret;
  c.session.number = number_of(r);
  c.session.patience = kPatience;
  if (!member)
    c.session.begins_at =
        home_ ? places_.at(*home_).peer->session().session_now(local) : finder_.clock(local).value_or(0);
  c.replica.technique = config_.technique;
  c.replica.kept_ticks = kKeptTicks;
  if (config_.on_confirmed)
    c.on_confirmed = [this, r](int /*incarnation*/, const sync::FoldState& s, std::uint64_t hash) {
      config_.on_confirmed(r, s, hash);
    };
  Place& place = places_[r];
  place.peer = std::make_unique<node::Participant>(scene, std::move(c), local);
  place.by = member;
  retry_.erase(r);
  ++stats_.entered;
  if (!member) ++stats_.founded;
}

void CrowdPeer::push(Region r, EntityId body, Vec2 velocity) {
  const auto it = places_.find(r);
  if (it != places_.end() && it->second.peer->playing()) it->second.peer->push(body, velocity);
}

void CrowdPeer::receive(const Endpoint& from, std::span<const std::byte> datagram, Micros local) {
  const auto number = session_of(datagram);
  if (number == 0) return finder_.receive(from, datagram, local);
  for (auto& [region, place] : places_)
    if (number == number_of(region)) place.peer->receive(from, datagram, local);
}

void CrowdPeer::unreachable(const Endpoint& at, Micros local) {
  for (auto& [region, place] : places_) place.peer->unreachable(at, local);
}

void CrowdPeer::turn(const std::function<Vec2(Tick)>& target, Micros local) {
  for (auto& [region, place] : places_) {
    if (local >= place.peer->next_due()) place.peer->advance(local);
    note_life(place);
  }
  if (leaving_) return say_goodbye(local);
  find(local);
  const Region first = region_at(config_.plane, config_.start);
  if (const auto it = places_.find(first); !home_ && it != places_.end() && it->second.peer->playing()) home_ = first;
  while (home_ && places_.at(*home_).peer->step_due(local)) tick(target(now() + 1), local);
  end_places(local);
}

Micros CrowdPeer::next_due() const {
  Micros due = leaving_ ? std::numeric_limits<Micros>::max() : finder_.next_due();
  for (const auto& [region, place] : places_) {
    due = std::min(due, place.peer->next_due());
    if (place.peer->playing() && (leaving_ || region == home_)) due = std::min(due, place.peer->next_step());
  }
  return due;
}

// In another incarnation it sits in another slot, and has said nothing yet.
void CrowdPeer::note_life(Place& place) {
  if (place.peer->incarnation() <= place.incarnation) return;
  if (place.incarnation >= 0) ++stats_.merged;
  place.incarnation = place.peer->incarnation();
  place.said = -1;
}

void CrowdPeer::leave(Micros local) {
  leaving_ = true;
  std::erase_if(places_, [](const auto& p) { return !p.second.peer->playing(); });
  for (auto& [region, place] : places_)
    if (!place.peer->leaving()) place.peer->leave(local);
}

// Every region ends by itself, home too: the avatar stands where it is.
void CrowdPeer::say_goodbye(Micros local) {
  for (auto& [region, place] : places_) {
    const BodyState stands = held_near(config_.plane, region, avatar_);
    while (place.peer->step_due(local)) place.peer->step_led(stands, stands, stands.position, local);
  }
  end_places(local);
}

// In a region an avatar moves by itself once the agreed world there has it.
bool CrowdPeer::drives(const Place& place) const {
  const node::Replica& n = place.peer->replica();
  return n.member() && n.agreed().predicted_state().avatars[n.self()].present;
}

void CrowdPeer::tick(Vec2 target, Micros local) {
  const BodyState before = avatar_;
  Place& home = places_.at(*home_);
  if (drives(home)) {
    home.peer->step(target, local);
    avatar_ = home.peer->replica().live().world().state(home.peer->replica().live().avatar());
  } else {
    home.peer->step_led(before, before, target, local);
  }
  ++stats_.node_ticks;
  for (auto& [region, place] : places_)
    if (region != *home_ && place.peer->playing()) lead(region, place, before, target, local);
  go_home();
  steer(local);
  if (now() % kCustoms == 0) handover_.work(posts());
  if (now() % kReconsider == 0) reconsider(local);
}

// A peer has one clock, that of its home, and takes it along when it goes home elsewhere. At home the clock that counts
// is that of the lowest member.
void CrowdPeer::steer(Micros local) {
  node::Participant& home = *places_.at(*home_).peer;
  if (home.replica().now() % kSteer == 0) home.steer(local);
  for (auto& [region, place] : places_)
    if (region != *home_ && place.peer->playing()) place.peer->session().state().clock = home.session().clock();
}

void CrowdPeer::lead(Region r, Place& place, const BodyState& before, Vec2 target, Micros local) {
  const BodyState from = held_near(config_.plane, r, before);
  const BodyState to = held_near(config_.plane, r, avatar_);
  const Tick now = this->now();
  while (place.peer->replica().now() < now) {
    place.peer->step_led(from, place.peer->replica().now() + 1 < now ? from : to, target, local);
    ++stats_.node_ticks;
  }
  const node::Replica& n = place.peer->replica();
  Place& home = places_.at(*home_);
  if (n.reaction() != Vec2{} && drives(place) && touches_only_strangers(n, home.peer->replica()))
    home.peer->jolt(n.reaction());
}

// The world that drives the avatar is the one it is in; which is no news to the others there.
void CrowdPeer::go_home() {
  const Region r = region_at(config_.plane, avatar_.position);
  if (r == *home_ || inside(config_.plane, r, avatar_.position) < config_.plane.threshold) return;
  const auto it = places_.find(r);
  const bool in = it != places_.end() && !it->second.peer->leaving() && it->second.peer->playing() &&
                  drives(it->second) && it->second.peer->replica().now() == now();
  if (!in) {
    ++stats_.late;
    return;
  }
  home_ = r;
  it->second.peer->set_coarseness(1);
  ++stats_.handovers;
}

void CrowdPeer::reconsider(Micros local) {
  const Plane& plane = config_.plane;
  wanted_ = around(plane, avatar_.position, plane.reach);
  for (const Region r : around(plane, avatar_.position + avatar_.velocity * plane.ahead, plane.reach))
    if (!contains(wanted_, r)) wanted_.push_back(r);
  if (!contains(wanted_, *home_)) wanted_.push_back(*home_);
  for (const Region r : handover_.errands())
    if (!contains(wanted_, r)) wanted_.push_back(r);
  for (auto& [region, place] : places_) {
    // Who is coming in may have been admitted already, and would be waited for: it leaves when it is in.
    if (place.peer->leaving() || !place.peer->playing() || !place.peer->replica().member()) continue;
    const bool near = outside(plane, region, avatar_.position) <= plane.reach + plane.linger;
    const bool go = !near && !contains(wanted_, region);
    say_whether_going(place, go);
    if (!go || !may_leave(place)) continue;
    place.peer->leave(local);
  }
  if (config_.relevance) adapt_thresholds();
}

void CrowdPeer::say_whether_going(Place& place, bool go) {
  const node::Replica& n = place.peer->replica();
  if (n.orders() > 0) return;
  if (n.agreed().predicted_state().members[n.self()].going == go) {
    if (place.said < 0) place.said = n.now();
    return;
  }
  place.said = -1;
  sync::Bundle b;
  b.going = go;
  place.peer->order(b);
}

// Whoever wants to leave says so, and leaves once all agree that it does and that somebody is there who does not. That
// one has to say so too before it leaves, and nobody is left then to whom it could leave the region: so the last one
// never goes, in whatever order words arrive. What counts is the last word: who has changed its mind in between would
// else leave by what it said before, to one who leaves by what it said then. Who has been let in but has not said where
// its avatar is may not know of it yet, and does not count.
bool CrowdPeer::may_leave(const Place& place) {
  const node::Replica& n = place.peer->replica();
  const sync::FoldState& confirmed = n.agreed().confirmed();
  if (place.said < 0 || confirmed.tick < place.said || !confirmed.members[n.self()].going) return false;
  for (PeerId p = 0; p < confirmed.members.size(); ++p)
    if (p != n.self() && confirmed.avatars[p].present && !confirmed.members[p].going && n.seat(p).there()) return true;
  return false;
}

void CrowdPeer::adapt_thresholds() {
  for (auto& [region, place] : places_)
    if (region != *home_ && place.peer->playing())
      place.peer->set_coarseness(coarseness_of(config_.plane, region, place.peer->replica()));
}

void CrowdPeer::retire(Place& place) {
  if (!place.peer->playing()) return;
  const node::ReplicaStats& s = place.peer->replica().stats();
  for (const std::uint64_t n : s.updates_by_cause) past_updates_ += n;
}

void CrowdPeer::end_places(Micros local) {
  for (auto it = places_.begin(); it != places_.end();) {
    Place& p = it->second;
    const bool failed = p.peer->failed();
    const bool gone = p.peer->done(local);
    if (!failed && !gone) {
      ++it;
      continue;
    }
    if (failed) ++stats_.failed;
    retry_[it->first] = local + (failed ? kRetry : 0);
    if (failed && p.by) finder_.distrust(it->first, *p.by, local);
    outgoing_.add(p.peer->take_outgoing());
    retire(p);
    it = places_.erase(it);
  }
}

std::span<const node::Parcel> CrowdPeer::take_outgoing() {
  for (auto& [region, place] : places_) {
    outgoing_.add(place.peer->take_outgoing());
    for (node::SessionEvent& e : place.peer->take_events())
      if (events_.size() < kEventsKept) events_.emplace_back(region, std::move(e));
    place.peer->take_changes();
  }
  outgoing_.add(finder_.take_outgoing());
  const std::span<const node::Parcel> all = outgoing_.take();
  stats_.datagrams += all.size();
  for (const node::Parcel& p : all) stats_.wire_bytes += p.bytes.size() + node::kIpUdpBytes;
  return all;
}

std::vector<std::pair<Region, node::SessionEvent>> CrowdPeer::take_events() {
  return std::exchange(events_, {});
}

std::vector<Post> CrowdPeer::posts() const {
  std::vector<Post> all;
  for (const auto& [region, place] : places_)
    if (place.peer->playing() && !place.peer->leaving() && place.peer->replica().member())
      all.push_back({region, place.peer.get()});
  return all;
}

std::uint64_t CrowdPeer::updates() const {
  std::uint64_t n = past_updates_;
  for (const auto& [region, place] : places_)
    if (place.peer->playing())
      for (const std::uint64_t u : place.peer->replica().stats().updates_by_cause) n += u;
  return n;
}

}  // namespace padr::crowd
