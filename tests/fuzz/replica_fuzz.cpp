// A whole peer, fed payloads sealed as another member would seal them: a member that says anything at all, orders of
// who comes and goes included.
#include <algorithm>

#include "common/replica/replica.h"
#include "common/scenarios/scenarios.h"
#include "common/wire/codec.h"
#include "tests/fuzz/bytes.h"
#include "tests/fuzz/good.h"

namespace {

using namespace padr;

constexpr int kSlots = 4;

sync::Bundle any_said(Rng& rng, PeerId peer, std::uint32_t index, Tick tick) {
  sync::Bundle b;
  b.peer = peer;
  b.index = index;
  b.tick = tick;
  const auto slot = static_cast<PeerId>(rng.below(kSlots));
  const auto some = [&rng] { return rng.below(rng.chance(0.1) ? 1U << 30U : 4); };
  switch (rng.below(6)) {
    case 0:
      b.admission = sync::Admission{slot, 1 + some(), some(), {}, {some(), some(), some(), some()}};
      b.admission->spectator = rng.chance(0.2);
      b.admission->at.address[15] = 1;
      b.admission->at.port = 1;
      break;
    case 1:
      b.removals.push_back({slot, some(), some()});
      break;
    case 2:
      if (slot != peer && tick > 0) b.passed_on.push_back(any_said(rng, slot, some(), tick - 1));
      if (!b.passed_on.empty()) b.passed_on[0].passed_on.clear();
      break;
    case 3:
      (rng.chance(0.5) ? b.leave : b.spectates) = rng.chance(0.2);
      break;
    default:
      b.avatar = sync::AvatarUpdate{};
      b.avatar->position = {5, 5};
      b.bodies.emplace_back();
      b.bodies[0].has_state = true;
      b.bodies[0].epoch = 1 + some();
      b.bodies[0].state.position = {6, 7};
  }
  return b;
}

}  // namespace

// Each payload is preceded by its length, in one byte.
padr::wire::Bytes padr::test::good_input(Rng& rng) {
  wire::Bytes all;
  std::uint32_t index = 0;
  for (Tick t = 1; t < 40; ++t) {
    if (rng.chance(0.3)) continue;
    sync::StatePacket p;
    p.seq = static_cast<std::uint32_t>(t);
    p.mark_tick = t;
    if (rng.chance(0.6)) p.updates.push_back(any_said(rng, 1, index++, t));
    p.mark_count = index;
    p.have = rng.below(3);
    p.seen_seq = rng.below(static_cast<std::uint32_t>(t));
    const wire::Bytes payload = wire::encode(p);
    if (payload.size() > 255) continue;
    all.push_back(static_cast<std::byte>(payload.size()));
    all.insert(all.end(), payload.begin(), payload.end());
  }
  return all;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Scene kScene = scenarios::load_embedded("proxy", 1);
  node::ReplicaConfig config;
  config.peers = 2;
  config.slots = kSlots;
  node::Replica replica(kScene, config);
  Tick t = 0;
  while (size > 1 && t < 200) {
    const std::size_t length = std::min<std::size_t>(data[0], size - 1);
    const auto payload = test::bytes(data + 1, length);
    replica.receive(wire::seal({wire::Kind::kState, 1, 0}, payload), tick_start(t));
    data += length + 1;
    size -= length + 1;
    replica.step({5, 5});
    ++t;
  }
  return 0;
}
