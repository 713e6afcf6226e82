#include <cmath>

#include "tools/lab/alternatives/entrants/entrant.h"
#include "tools/lab/alternatives/replica.h"

// What a first try looks like, and how a contestant is added in one file: 20 times a second a peer tells where its
// avatar and its bodies are that move, in whole floats, and whoever hears of it puts them there. Every two seconds it
// tells of all that it has ever moved, because of what was lost.
namespace padr::lab::alternatives {
namespace {

constexpr Tick kEvery = 3;  // ticks
constexpr Tick kAgain = 2 * kTicksPerSecond;
constexpr std::size_t kStateBits = 16 + 16 + 1 + 3 * 32;
constexpr std::size_t kMost = (wire::kMaxPayload * 8 - kTickBits - 16) / kStateBits;

class Positions final : public Replica {
 public:
  Positions(const Scene& scene, const AlternativeConfig& config)
      : Replica(scene, config), newest_(static_cast<std::size_t>(world_.entities()), -1) {
    for (EntityId e = 0; e < world_.entities(); ++e) told_.push_back(world_.state(e));
  }

 protected:
  bool take(PeerId from, BitReader& r) override {
    const Tick tick = whole_tick(r.get(kTickBits), now());
    const std::uint32_t count = r.get(16);
    for (std::uint32_t i = 0; i < count; ++i)
      if (!take_one(from, tick, r)) return false;
    return r.ok();
  }

  /// Others' things are where they were told to be, and stay there until they are told of again.
  void place_others() override {
    for (EntityId e = 0; e < world_.entities(); ++e)
      if (!is_mine(e)) world_.set_state(e, told_[e]);
  }

  void send() override {
    if (now() % kEvery != 0) return;
    std::vector<EntityId> mine;
    for (EntityId e = 0; e < world_.entities() && mine.size() < kMost; ++e)
      if (is_mine(e) && to_tell(e)) mine.push_back(e);
    if (mine.empty()) return;
    BitWriter w;
    w.put(static_cast<std::uint32_t>(now()) & 0xFFFFU, kTickBits);
    w.put(static_cast<std::uint32_t>(mine.size()), 16);
    for (const EntityId e : mine) write(w, e);
    for (PeerId p = 0; p < peers(); ++p)
      if (p != self()) post(p, w, mine.size());
  }

 private:
  bool to_tell(EntityId e) const {
    if (!(world_.position(e) == told_[e].position)) return true;
    return now() % kAgain < kEvery && (world_.is_avatar(e) || claims_.of(e).sequence > 0);
  }

  void write(BitWriter& w, EntityId e) {
    told_[e] = world_.state(e);
    const Claim claim = world_.is_avatar(e) ? Claim{} : claims_.of(e);
    w.put(e, 16);
    w.put(claim.sequence, 16);
    w.flag(claim.held);
    w.put_float(told_[e].position.x);
    w.put_float(told_[e].position.y);
    w.put_float(told_[e].angle);
  }

  bool take_one(PeerId from, Tick tick, BitReader& r) {
    const auto e = static_cast<EntityId>(r.get(16));
    const auto sequence = static_cast<std::uint16_t>(r.get(16));
    const Claim claim{from, sequence, r.flag(), true};
    BodyState s;
    s.position = {r.get_float(), r.get_float()};
    s.angle = r.get_float();
    const bool sane = r.ok() && e < world_.entities() && length(s.position) < 1e4F && std::abs(s.angle) < 1e5F;
    if (!sane || (world_.is_avatar(e) && e != world_.avatar(from))) return false;
    if (!world_.is_avatar(e) && !claims_.hear(e, claim)) return true;
    if (tick <= newest_[e]) return true;
    newest_[e] = tick;
    told_[e] = s;
    return true;
  }

  std::vector<BodyState> told_;  ///< by entity: as it was told last, by whomever
  std::vector<Tick> newest_;     ///< by entity: of what was told last
};

}  // namespace

namespace entrants {

std::vector<Entrant> positions() {
  const Maker make = [](const Scene& scene, const AlternativeConfig& config) -> std::unique_ptr<Alternative> {
    return std::make_unique<Positions>(scene, config);
  };
  return {{"positions", "places of what moves, 20 times a second, in whole floats: a first try",
           Spec{.kind = Kind::kEntrant, .hz = kTicksPerSecond / kEvery, .make = make}}};
}

}  // namespace entrants
}  // namespace padr::lab::alternatives
