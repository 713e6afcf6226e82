#include "tools/report/traffic.h"

#include "common/wire/codec.h"

namespace padr::report {
namespace {

struct Share {
  std::size_t cause = 0;
  double weight = 0;  ///< bytes the entity takes when it is alone in a bundle
};

/// The entity updates of a bundle.
std::vector<Share> shares_of(const sync::Bundle& b) {
  std::vector<Share> shares;
  sync::Bundle alone;
  if (b.avatar) {
    alone.avatar = b.avatar;
    shares.push_back({static_cast<std::size_t>(b.avatar->cause), static_cast<double>(wire::encoded_size(alone))});
    alone.avatar.reset();
  }
  for (const sync::BodyUpdate& u : b.bodies) {
    alone.bodies = {u};
    shares.push_back({static_cast<std::size_t>(u.cause), static_cast<double>(wire::encoded_size(alone))});
  }
  if (b.leave) shares.push_back({static_cast<std::size_t>(sync::Cause::kLeave), 1});
  return shares;
}

/// Bytes that a bundle adds to its packet, exactly.
double size_in(const sync::StatePacket& packet, const sync::Bundle& b) {
  sync::StatePacket alone = packet;
  alone.updates.clear();
  const std::size_t without = wire::encode(alone).size();
  alone.updates.push_back(b);
  return static_cast<double>(wire::encode(alone).size() - without);
}

}  // namespace

void TrafficMeter::sent(PeerId to, Tick tick, const sync::StatePacket& packet, std::size_t wire_bytes) {
  Traffic t;
  t.datagrams = 1;
  t.wire_bytes = wire_bytes;
  for (const sync::Bundle& b : packet.updates) bundle(to, b, size_in(packet, b), t);
  total_ += t;
  const auto second = static_cast<std::size_t>(tick / kTicksPerSecond);
  if (second >= per_second_.size()) per_second_.resize(second + 1);
  per_second_[second] += t;
}

void TrafficMeter::bundle(PeerId to, const sync::Bundle& b, double size, Traffic& into) {
  if (!told_[to].insert(b.index).second) {
    ++into.repeats;
    into.bytes_repeats += size;
    return;
  }
  const std::vector<Share> shares = shares_of(b);
  double weights = 0;
  for (const Share& s : shares) weights += s.weight;
  for (const Share& s : shares) into.bytes_by_cause[s.cause] += size * s.weight / weights;
  if (!counted_.insert(b.index).second) return;
  for (const Share& s : shares) ++into.updates[s.cause];
}

}  // namespace padr::report
