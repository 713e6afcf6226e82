#include "tools/lab/chaos/liar_part.h"

#include <algorithm>
#include <utility>

namespace padr::lab {

LiarPart::LiarPart(VirtualNetwork& network, Judge& judge, const ChaosScript& script)
    : network_(network), judge_(judge), script_(script), rng_(derive_seed(script.seed, script.liar->pick)) {
  network_.on_start = [this](int person, node::ParticipantConfig& c) {
    if (!is_to_lie(person)) return;
    judge_.expect_lies_of(person);
    Part& part = parts_[person];
    if (c.channels) part.liar.learn_key(*c.channels);
    c.tamper = [&part](node::Parcel p) { return part.liar.tamper(std::move(p)); };
  };
}

bool LiarPart::is_to_lie(int person) {
  if (person < script_.founders)
    return person == static_cast<int>(script_.liar->pick % static_cast<std::uint64_t>(script_.founders));
  const bool runs = std::any_of(parts_.begin(), parts_.end(), [this](const auto& p) { return network_.runs(p.first); });
  return !runs && rng_.chance(0.5);
}

bool LiarPart::lies_now() const {
  const Micros now = network_.now();
  return std::any_of(script_.liar->times.begin(), script_.liar->times.end(),
                     [now](const LyingScript::Span& t) { return now >= t.from && now < t.to; });
}

void LiarPart::advance() {
  for (auto& [person, part] : parts_) {
    const node::Participant& peer = network_.peer(person);
    if (!network_.runs(person) || !peer.playing()) continue;
    part.liar.learn_session(peer.session().id());
    if (!part.plot && lies_now()) {
      const auto variant = static_cast<std::uint32_t>(script_.liar->pick >> 32U);
      part.plot = std::make_shared<Deceiver>(part.liar, peer, rng_.next_u64(), variant);
      script_.liar->how->begin(part.plot);
    }
    if (part.plot) part.plot->active = lies_now();
    led_ = led_ || (lies_now() && peer.coordinator() == peer.replica().self());
  }
}

std::uint64_t LiarPart::told() const {
  std::uint64_t all = 0;
  for (const auto& [person, part] : parts_) all += part.liar.told;
  return all;
}

}  // namespace padr::lab
