#include "tools/lab/crowd/crowd.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>

#include "common/model/rng.h"
#include "common/scenarios/wander.h"

namespace padr::lab {
namespace {

/// Hashes of ticks that lie so far back have been compared with everybody's.
constexpr Tick kRemembered = 20 * kTicksPerSecond;

/// Ticks that every datagram is on its way at least; 1 if that is not known.
Tick stride_of(const link::NetemSpec& s) {
  constexpr Tick kMost = 6;
  constexpr link::Nanos kTick = 1'000'000'000 / kTicksPerSecond;
  const bool bounded = s.delay.jitter == 0 || s.delay.distribution == link::Distribution::kUniform;
  if (!bounded || s.reorder.chance != link::Chance{} || s.gap != 0) return 1;
  return std::clamp(static_cast<Tick>((s.delay.mean - s.delay.jitter) / kTick), Tick{1}, kMost);
}

double thread_seconds() {
  std::timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

Endpoint place_number(int n) {
  const auto u = static_cast<unsigned>(n + 1);
  return ipv4(
      {10, static_cast<std::uint8_t>(u >> 16U), static_cast<std::uint8_t>(u >> 8U), static_cast<std::uint8_t>(u)},
      7000);
}

/// The same for all who have come into a region by way of one another.
std::uint64_t side_of(const sync::FoldState& s) {
  Hasher h;
  for (const sync::Member& m : s.members)
    h.add(static_cast<std::uint64_t>(m.present) << 32U | std::uint64_t{m.incarnation});
  return h.value();
}

}  // namespace

CrowdRun::CrowdRun(CrowdRunConfig config)
    : config_(std::move(config)),
      stride_(stride_of(config_.netem)),
      links_(link::LinkMesh::between_parties(config_.netem, config_.seed)),
      persons_(static_cast<std::size_t>(config_.peers)),
      workers_(config_.threads) {
  links_.reserve(persons_.size());
  for (int i = 0; i < config_.peers; ++i) place(i);
}

CrowdRun::~CrowdRun() = default;

// Everybody strolls about a square of its own, all of them on a square whose size is that of the crowd. One after the
// other on a grid, so that they are spread evenly whatever their number.
void CrowdRun::place(int person) {
  Person& p = persons_[at(person)];
  Rng rng(derive_seed(config_.seed, 0xC40, static_cast<std::uint64_t>(person)));
  const float ground = std::sqrt(static_cast<float>(config_.peers) * config_.room);
  const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<float>(config_.peers))));
  const int rows = (config_.peers + columns - 1) / columns;
  const Vec2 cell{ground / static_cast<float>(columns), ground / static_cast<float>(rows)};
  const auto draw = [&rng](float size) { return static_cast<float>(rng.uniform(0.1, 0.9)) * size; };
  const int row = person / columns;
  Vec2 start{static_cast<float>(person % columns) * cell.x, static_cast<float>(row) * cell.y};
  start.x += draw(cell.x);
  start.y += draw(cell.y);
  if (at(person) < config_.starts.size()) start = config_.starts[at(person)];
  scenarios::WanderOptions o;
  const float side = std::min(config_.stroll, ground);
  o.lower = {std::clamp(start.x - side / 2, 0.0F, ground - side), std::clamp(start.y - side / 2, 0.0F, ground - side)};
  o.upper = o.lower + Vec2{side, side};
  p.from_edge = std::min({o.lower.x, o.lower.y, ground - o.upper.x, ground - o.upper.y});
  o.start = start;
  o.slot = person;
  p.input = std::make_unique<scenarios::Wander>(o, derive_seed(config_.seed, 0x3A1));
  p.place = place_number(person);
  p.comes = static_cast<Tick>(std::lround(person * kTicksPerSecond / config_.arrivals));
  by_place_[p.place] = person;
  crowd::CrowdConfig c;
  c.plane = config_.plane;
  c.technique = config_.technique;
  c.relevance = config_.relevance;
  c.fingerprint = 1;
  c.seed = rng.next_u64();
  c.start = start;
  if (person > 0) c.contact = place_number(0);
  c.on_confirmed = [&p](crowd::Region r, const sync::FoldState& s, std::uint64_t hash) {
    p.confirmed.push_back({r, s.tick, side_of(s), hash});
  };
  p.peer = std::make_unique<crowd::CrowdPeer>(c);
}

int CrowdRun::person_at(const Endpoint& place) const {
  const auto it = by_place_.find(place.place());
  return it == by_place_.end() ? -1 : it->second;
}

void CrowdRun::stop_input() {
  standing_ = true;
  for (Person& p : persons_) p.stands = p.peer->avatar().position;
}

void CrowdRun::advance() {
  links_.deliver(time_of(now_ + stride_), [this](std::size_t from, std::size_t to, Micros when, wire::Bytes datagram) {
    persons_[to].inbox.push_back({when, from, std::move(datagram)});
  });
  workers_.run(persons_.size(), [this](std::size_t i) { work(i); });
  now_ += stride_;
  compare();
  note_members();
}

void CrowdRun::work(std::size_t person) {
  Person& p = persons_[person];
  if (p.suspended) {
    p.inbox.clear();
    p.stood_still += stride_;
    return;
  }
  std::stable_sort(p.inbox.begin(), p.inbox.end(), [](const Arrival& a, const Arrival& b) { return a.at < b.at; });
  for (Tick t = now_ + 1; t <= now_ + stride_; ++t) {
    if (t < p.comes) continue;
    shove(person, t);
    work_a_tick(person, time_of(t));
  }
}

void CrowdRun::work_a_tick(std::size_t person, Micros time) {
  Person& p = persons_[person];
  const Micros local = time - tick_start(p.stood_still);
  const double before = thread_seconds();
  const auto next = std::find_if(p.inbox.begin(), p.inbox.end(), [time](const Arrival& a) { return a.at > time; });
  for (auto a = p.inbox.begin(); a != next; ++a) p.peer->receive(persons_[a->from].place, a->bytes, local);
  p.inbox.erase(p.inbox.begin(), next);
  p.peer->turn([this, person](Tick t) { return target_of(person, t); }, local);
  const std::span<const node::Parcel> parcels = p.peer->take_outgoing();
  p.cpu += thread_seconds() - before;
  for (const node::Parcel& d : parcels) {
    const int to = person_at(d.to);
    if (to < 0) continue;
    links_.send(person, at(to), time, d.bytes);
    p.spoken_to.insert(to);
  }
}

Vec2 CrowdRun::target_of(std::size_t person, Tick t) {
  Person& p = persons_[person];
  if (p.stands) return *p.stands;
  return config_.drive ? config_.drive(static_cast<int>(person), t) : p.input->target(t);
}

void CrowdRun::shove(std::size_t person, Tick t) {
  constexpr float kNear = 6;   // m
  constexpr float kSpeed = 6;  // m/s
  Person& p = persons_[person];
  Rng rng(derive_seed(config_.seed, 0x5403E + person, static_cast<std::uint64_t>(t)));
  if (standing_ || !p.peer->playing() || !rng.chance(config_.shoves / kTicksPerSecond)) return;
  std::vector<std::pair<crowd::Region, EntityId>> near;
  for (const crowd::Post& post : p.peer->posts()) {
    const node::Replica& n = post.peer->replica();
    for (EntityId b = 0; b < n.live().residents().slots.size(); ++b)
      if (n.live().residents().slots[b].present &&
          distance(n.live().world().position(b), p.peer->avatar().position) < kNear)
        near.emplace_back(post.region, b);
  }
  const double angle = rng.uniform(0, 6.28);
  if (near.empty()) return;
  const auto& [region, body] = near[rng.below(static_cast<std::uint32_t>(near.size()))];
  p.peer->push(region, body, Vec2{static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))} * kSpeed);
}

void CrowdRun::compare() {
  for (Person& p : persons_) {
    for (const Confirmed& c : p.confirmed) {
      auto& sides = hashes_[c.region][c.tick];
      const auto [it, fresh] = sides.try_emplace(c.side, c.hash);
      confirmed_ += fresh && sides.size() == 1 ? 1U : 0U;
      split_ += fresh && sides.size() == 2 ? 1U : 0U;
      if (fresh) continue;
      ++compared_;
      if (it->second != c.hash) ++different_;
    }
    p.confirmed.clear();
  }
  for (auto& [region, ticks] : hashes_) ticks.erase(ticks.begin(), ticks.lower_bound(now_ - kRemembered));
}

void CrowdRun::note_members() {
  members_.clear();
  for (int i = 0; i < persons(); ++i)
    for (const crowd::Post& post : persons_[at(i)].peer->posts()) members_[post.region].push_back(i);
}

std::size_t CrowdRun::take_links() {
  std::size_t n = 0;
  for (Person& p : persons_) n += std::exchange(p.spoken_to, {}).size();
  return n;
}

}  // namespace padr::lab
