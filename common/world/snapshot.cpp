#include "common/world/snapshot.h"

namespace padr::world {

void add_to_hash(WideHasher& h, const Snapshot& s) {
  const auto word = [](Vec2 v) { return Hasher::word(v.x, v.y); };
  h.add(s.entities.size(), s.contacts.size(), 0, 0);
  for (const Kinematics& k : s.entities)
    h.add(word(k.position), word(k.velocity), Hasher::word(k.angle, k.spin),
          Hasher::word(k.awake ? 1.0F : 0.0F, k.sleep_time));
  for (const ContactState& c : s.contacts) {
    const auto& [p, q] = c.points;
    const std::uint64_t kind = static_cast<std::uint64_t>(c.key) << 32U | static_cast<std::uint64_t>(c.type) << 16U |
                               static_cast<std::uint64_t>(c.count) << 8U | static_cast<std::uint64_t>(c.touching);
    const std::uint64_t ids =
        static_cast<std::uint64_t>(c.count > 0 ? p.id : 0) << 32U | std::uint64_t{c.count > 1 ? q.id : 0};
    h.add(kind, word(c.local_normal), word(c.local_point), ids);
    if (c.count == 0) continue;
    const ContactState::Point second = c.count > 1 ? q : ContactState::Point{};
    h.add(word(p.local), Hasher::word(p.normal_impulse, p.tangent_impulse), word(second.local),
          Hasher::word(second.normal_impulse, second.tangent_impulse));
  }
}

}  // namespace padr::world
