#include "tests/fuzz/small_net.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "common/model/rng.h"
#include "common/scenarios/scenarios.h"

namespace padr::test {
namespace {

constexpr Micros kTurn = kMicrosPerSecond / kTicksPerSecond;
constexpr std::size_t kKept = 256;
constexpr int kMostTurns = 300;  // until all play

wire::Key drawn(std::uint64_t seed) {
  Rng rng(seed);
  wire::Key key{};
  for (auto& b : key) b = static_cast<std::uint8_t>(rng.below(256));
  return key;
}

const Scene& small_scene() {
  static const Scene kScene = scenarios::load_embedded("proxy", 1);
  return kScene;
}

}  // namespace

Endpoint SmallNet::place(int n) {
  return ipv4({10, 0, 0, static_cast<std::uint8_t>(n + 1)}, 7000);
}

SmallNet::SmallNet(int peers, std::uint64_t session, wire::SealMode mode)
    : SmallNet(peers, session, mode, small_scene(), peers) {}

SmallNet::SmallNet(int peers, std::uint64_t session, wire::SealMode mode, const Scene& scene, int slots)
    : key_(drawn(session)) {
  people_.resize(static_cast<std::size_t>(peers));
  for (int p = 0; p < peers; ++p) {
    Person& who = people_[static_cast<std::size_t>(p)];
    node::ParticipantConfig config;
    if (p > 0) config.session.join = place(0);
    config.session.wanted = peers;
    config.session.slots = slots;
    config.session.seed = derive_seed(session, 1, static_cast<std::uint64_t>(p));
    config.session.sealed = true;
    config.channels.emplace();
    config.channels->session = key_;
    config.channels->seed = who.seed = drawn(derive_seed(session, 2, static_cast<std::uint64_t>(p)));
    config.channels->random = [own = Rng(derive_seed(session, 3, static_cast<std::uint64_t>(p)))](auto out) mutable {
      for (std::byte& b : out) b = static_cast<std::byte>(own.below(256));
    };
    config.tamper = [this, p](node::Parcel parcel) {
      return tamper ? tamper(p, std::move(parcel)) : std::vector{std::move(parcel)};
    };
    config.channels->mode = mode;
    // Each key is told for both directions, ours first.
    config.channels->on_key = [&who](const PublicKey&, const PublicKey& to, const wire::Key& key) {
      who.keys.insert_or_assign(to, key);
    };
    config.on_confirmed = [this, p](int, const sync::FoldState& s, std::uint64_t hash) {
      if (on_confirmed) on_confirmed(p, s.tick, hash);
    };
    who.peer = std::make_unique<node::Participant>(scene, std::move(config), now_);
  }
}

bool SmallNet::come_together() {
  const auto all_play = [this] {
    return std::all_of(people_.begin(), people_.end(),
                       [](const Person& p) { return p.peer->playing() && p.peer->replica().now() > 0; });
  };
  for (int i = 0; i < kMostTurns && !all_play(); ++i) turn();
  return all_play();
}

void SmallNet::turn() {
  now_ += kTurn;
  for (int p = 0; p < peers(); ++p)
    for (const Passing& d : std::exchange(people_[static_cast<std::size_t>(p)].coming, {}))
      arrive(p, place(d.from), d.bytes);
  for (int p = 0; p < peers(); ++p) {
    node::Participant& peer = *people_[static_cast<std::size_t>(p)].peer;
    if (now_ >= peer.next_due()) peer.advance(now_);
    while (peer.step_due(now_)) peer.step(target ? target(p) : Vec2{5.0F + static_cast<float>(p), 5}, now_);
    for (const node::Parcel& parcel : peer.take_outgoing()) post(p, parcel);
    for (const node::SessionEvent& e : peer.take_events())
      if (on_event) on_event(p, e);
    peer.take_changes();
  }
}

void SmallNet::post(int from, node::Parcel parcel) {
  for (int to = 0; to < peers(); ++to) {
    if (!same_place(parcel.to, place(to)) || to == from) continue;
    if (lie) parcel.bytes = with_lies(from, to, parcel.bytes);
    Person& receiver = people_[static_cast<std::size_t>(to)];
    receiver.awaited.insert(text_of(parcel.bytes));
    sent_.push_back({from, to, parcel.bytes});
    if (sent_.size() > kKept) sent_.pop_front();
    if (losing_ > 0)
      --losing_;
    else
      receiver.coming.push_back({from, to, std::move(parcel.bytes)});
  }
}

wire::Bytes SmallNet::with_lies(int from, int to, const wire::Bytes& sealed) {
  const auto header = wire::read_sealed(sealed);
  if (!header) return sealed;  // the handshake's
  const auto key = person(from).keys.find(person(to).peer->channels()->key());
  if (key == person(from).keys.end()) return sealed;
  const auto unsealed = wire::unseal_with(key->second, header->number, sealed);
  if (!unsealed) std::abort();
  const wire::Bytes said = lie(from, to, *unsealed);
  return said == *unsealed ? sealed : wire::seal_with(key->second, header->mode, header->id, header->number, said);
}

void SmallNet::arrive(int to, const Endpoint& from, std::span<const std::byte> bytes) {
  Person& who = people_[static_cast<std::size_t>(to)];
  who.awaited.erase(text_of(bytes));
  who.peer->receive(from, bytes, now_);
}

void SmallNet::inject(const Endpoint& from, int to, std::span<const std::byte> bytes) {
  arrive(to, from, bytes);
}

}  // namespace padr::test
