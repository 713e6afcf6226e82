// A whole member of a running session, fed payloads of any kind, sealed, by a member and by strangers.
#include <algorithm>

#include "common/participant/participant.h"
#include "common/scenarios/scenarios.h"
#include "tests/fuzz/bytes.h"
#include "tests/fuzz/good.h"
#include "tests/wire/samples.h"

namespace {

using namespace padr;

constexpr std::size_t kHead = 3;  // of each payload: its kind, who sends it, its length

Endpoint place(unsigned n) {
  return ipv4({10, 0, 0, static_cast<std::uint8_t>(n)}, 7000);
}

void add(wire::Bytes& all, wire::Kind kind, std::uint32_t sender, const wire::Bytes& payload) {
  if (payload.size() > 255) return;
  all.push_back(static_cast<std::byte>(kind));
  all.push_back(static_cast<std::byte>(sender));
  all.push_back(static_cast<std::byte>(payload.size()));
  all.insert(all.end(), payload.begin(), payload.end());
}

}  // namespace

padr::wire::Bytes padr::test::good_input(Rng& rng) {
  constexpr std::uint64_t kNonce = 7;
  wire::Bytes all;
  for (int i = 0; i < 20; ++i) {
    const std::uint32_t sender = rng.below(4);
    switch (rng.below(6)) {
      case 0:  // its padding is added where it is fed in
        add(all, wire::Kind::kSession, sender, {});
        break;
      case 1:
        add(all, wire::Kind::kSession, sender, wire::encode_session(wire::Ping{i}));
        break;
      case 2:
        add(all, wire::Kind::kMembership, sender, wire::encode_membership(wire::Pull{kNonce, 0, ~0ULL, kNonce}));
        add(all, wire::Kind::kMembership, sender, wire::encode_membership(wire::Enter{kNonce}));
        break;
      case 3: {
        sync::StatePacket p = any_packet(rng, static_cast<PeerId>(sender));
        p.updates.clear();
        p.mark_tick = i;
        p.check_tick = -1;
        add(all, wire::Kind::kState, sender, wire::encode(p));
        break;
      }
      default:
        add(all, wire::Kind::kMembership, sender,
            wire::encode_membership(any_membership(rng, rng.below(kMembershipKinds))));
    }
  }
  return all;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Scene kScene = scenarios::load_embedded("proxy", 1);
  node::ParticipantConfig config;
  config.session.wanted = 1;
  config.session.slots = 4;
  Micros now = 0;
  node::Participant founder(kScene, config, now);
  founder.advance(now);
  const std::uint16_t number = founder.session().number();
  for (int i = 0; size > kHead && i < 200; ++i) {
    const auto kind = static_cast<wire::Kind>(data[0] % 3);
    const auto sender = static_cast<PeerId>(data[1] % 4);
    const std::size_t length = std::min<std::size_t>(data[2], size - kHead);
    const auto payload = test::bytes(data + kHead, length);
    wire::Bytes datagram = wire::seal({kind, sender, number}, payload);
    if (kind == wire::Kind::kSession && length == 0)
      datagram = wire::seal({kind, kNoPeer, 0}, wire::encode_session(wire::Join{7, 0, 0, true, ""}));
    founder.receive(place(sender), datagram, now);
    data += kHead + length;
    size -= kHead + length;
    now += kMicrosPerSecond / 20;
    founder.advance(now);
    while (founder.step_due(now)) founder.step({5, 5}, now);
    founder.take_outgoing();
    founder.take_events();
    founder.take_changes();
  }
  return 0;
}
