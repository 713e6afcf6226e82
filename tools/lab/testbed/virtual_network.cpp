#include "tools/lab/testbed/virtual_network.h"

#include <cmath>
#include <utility>

#include "common/world/world.h"
#include "shell/input_text.h"
#include "shell/session_words.h"

namespace padr::lab {
namespace {

constexpr std::size_t kSocketBuffer = 300;  // datagrams

Endpoint place(int host, std::uint16_t port) {
  return ipv4({10, 0, static_cast<std::uint8_t>(host >> 8), static_cast<std::uint8_t>(host)}, port);
}

/// The same on the machine itself.
Endpoint on_loopback(const Endpoint& place) {
  return ipv4({127, 0, 0, 1}, place.port);
}

}  // namespace

VirtualNetwork::VirtualNetwork(VirtualNetworkConfig config)
    : config_(std::move(config)),
      links_(link::LinkMesh::between_parties(config_.netem, config_.seed)),
      loopback_links_(link::LinkMesh::between_parties(config_.netem, config_.seed)) {}
VirtualNetwork::~VirtualNetwork() = default;

Micros VirtualNetwork::local(const Person& p) const {
  return p.offset + std::llround(static_cast<double>(now_) * p.rate);
}

int VirtualNetwork::start(std::optional<int> by, bool over_loopback) {
  const int n = persons();
  Rng rng(derive_seed(config_.seed, 0xFACE, static_cast<std::uint64_t>(n)));
  Person& p = persons_.emplace_back();
  p.host = config_.host ? config_.host(n) : n;
  p.place = place(p.host + 1, static_cast<std::uint16_t>(config_.host ? 7000 + n : 7000));
  p.offset = static_cast<Micros>(rng.below(1'000'000)) * 10'000;
  p.rate = 1 + rng.uniform(-config_.most_ppm, config_.most_ppm) * 1e-6;
  if (config_.ppm) p.rate = 1 + config_.ppm(n) * 1e-6;
  p.born = now_;
  const auto spawns = static_cast<int>(config_.scene.avatar.spawns.size());
  p.input = shell::make_input("wander", {config_.scene, n % spawns, derive_seed(config_.seed, 7, rng.next_u64()), {}});
  node::ParticipantConfig c;
  if (by) c.session.join = over_loopback ? on_loopback(persons_[at(*by)].place) : persons_[at(*by)].place;
  p.by = by;
  c.session.wanted = config_.wanted;
  c.session.spectates = config_.spectates && config_.spectates(n);
  c.session.slots = config_.slots;
  c.session.fingerprint = 1;
  c.session.scenario = config_.scene.name;
  c.session.seed = rng.next_u64();
  c.session.secret = derive_seed(config_.seed, 0xC00C1E, static_cast<std::uint64_t>(n));
  c.replica.technique = config_.technique;
  if (config_.fault) c.replica.fault = config_.fault(n);
  if (config_.recording) c.recording = [this, n](int incarnation) { return config_.recording(n, incarnation); };
  c.on_confirmed = [this, n](int incarnation, const sync::FoldState& s, std::uint64_t hash) {
    if (on_confirmed) on_confirmed(n, incarnation, s, hash);
  };
  if (config_.seal != wire::SealMode::kNone) c.channels = channels_of(rng);
  if (on_start) on_start(n, c);
  by_place_[p.place] = n;
  p.peer = std::make_unique<node::Participant>(config_.scene, std::move(c), local(p));
  return n;
}

node::ChannelConfig VirtualNetwork::channels_of(Rng& rng) const {
  node::ChannelConfig g;
  g.mode = config_.seal;
  Rng key(derive_seed(config_.seed, 0x5EA1));
  for (auto& b : g.session) b = static_cast<std::uint8_t>(key.below(256));
  for (auto& b : g.seed) b = static_cast<std::uint8_t>(rng.below(256));
  std::uint64_t seed = 0;
  for (unsigned i = 0; i < 8; ++i) seed |= std::uint64_t{g.seed[i]} << (8 * i);
  g.random = [own = Rng(derive_seed(seed, 0x4E1))](std::span<std::byte> out) mutable {
    for (std::byte& b : out) b = static_cast<std::byte>(own.below(256));
  };
  return g;
}

bool VirtualNetwork::knocks_in_vain(int person) const {
  const Person& p = persons_[at(person)];
  return p.by && !runs(*p.by) && p.peer->incarnation() < 0 && p.peer->session().phase() == node::SessionPhase::kJoining;
}

bool VirtualNetwork::know_of_each_other(int p, int q) const {
  return peer(p).knows(place_of(q)) || peer(q).knows(place_of(p));
}

void VirtualNetwork::leave(int person) {
  Person& p = persons_[at(person)];
  p.peer->leave(local(p));
}

void VirtualNetwork::kill(int person) {
  persons_[at(person)].runs = false;
}

void VirtualNetwork::pause(int person, bool paused) {
  persons_[at(person)].paused = paused;
}

void VirtualNetwork::stand_still(int person, Micros duration) {
  persons_[at(person)].offset -= duration;
}

void VirtualNetwork::move(int person, const Endpoint& place) {
  Person& p = persons_[at(person)];
  by_place_.erase(p.place);
  p.place = place;
  by_place_[place] = person;
}

void VirtualNetwork::shape(const link::NetemSpec& netem) {
  links_.set_spec(now_, netem);
  loopback_links_.set_spec(now_, netem);
}

bool VirtualNetwork::connected(int a, int b) const {
  const auto side = [this](int p) {
    const auto it = sides_.find(p);
    return it == sides_.end() ? 0 : it->second;
  };
  return side(a) == side(b) && !cuts_.contains({a, b});
}

std::optional<int> VirtualNetwork::at_place(const Person& seen_by, const Endpoint& place) const {
  if (place.is_loopback()) {
    for (int p = 0; p < persons(); ++p)
      if (persons_[at(p)].host == seen_by.host && persons_[at(p)].place.port == place.port) return p;
    return std::nullopt;
  }
  const auto it = by_place_.find(place.place());
  return it == by_place_.end() ? std::nullopt : std::optional(it->second);
}

void VirtualNetwork::deliver() {
  for (const bool loopback : {false, true})
    (loopback ? loopback_links_ : links_)
        .deliver(now_, [&](std::size_t from, std::size_t to, Micros /*when*/, std::vector<std::byte> datagram) {
          arrive(from, to, loopback, std::move(datagram));
        });
}

void VirtualNetwork::arrive(std::size_t sender, std::size_t receiver, bool loopback, std::vector<std::byte> datagram) {
  Person& from = persons_[sender];
  Person& to = persons_[receiver];
  if (!connected(static_cast<int>(sender), static_cast<int>(receiver))) return;
  if (!to.runs) {
    if (config_.refusals) from.refused.push_back(loopback ? on_loopback(to.place) : to.place);
  } else if (to.buffer.size() < kSocketBuffer) {
    to.buffer.emplace_back(loopback ? on_loopback(from.place) : from.place, std::move(datagram));
  }
}

void VirtualNetwork::turn(int person) {
  Person& p = persons_[at(person)];
  if (!p.runs || p.paused) return;
  const Micros now = local(p);
  while (!p.buffer.empty()) {
    p.peer->receive(p.buffer.front().first, p.buffer.front().second, now);
    p.buffer.pop_front();
  }
  for (const Endpoint& e : std::exchange(p.refused, {})) p.peer->unreachable(e, now);
  if (now >= p.peer->next_due()) p.peer->advance(now);
  while (p.peer->step_due(now)) {
    if (p.took < 0) p.took = now_ - p.born;
    const Vec2 target = attraction_.value_or(p.input->target(p.peer->replica().now() + 1));
    p.peer->step(target, now);
  }
  for (const node::Parcel& d : p.peer->take_outgoing()) {
    p.to_nowhere = p.to_nowhere || !d.to.is_set();
    const auto to = at_place(p, d.to);
    if (!to) continue;
    if (on_datagram) on_datagram(p.place, *to, d.bytes);
    (d.to.is_loopback() ? loopback_links_ : links_).send(at(person), at(*to), now_, d.bytes);
  }
  for (const node::SessionEvent& e : p.peer->take_events())
    p.notes.push_back(std::to_string(static_cast<double>(now_) / 1e6) + " " + shell::words_of(e));
  p.peer->take_changes();
  if (on_turn) on_turn(person);
  end_if_done(p);
}

void VirtualNetwork::end_if_done(Person& p) {
  if (!p.peer->done(local(p)) && !p.peer->failed()) return;
  p.runs = false;
  p.peer->finish();
}

void VirtualNetwork::run_to(Micros until) {
  for (; now_ < until; now_ += kStep) {
    deliver();
    for (int p = 0; p < persons(); ++p) turn(p);
  }
}

void VirtualNetwork::finish() {
  for (Person& p : persons_)
    if (p.runs) p.peer->finish();
}

}  // namespace padr::lab
