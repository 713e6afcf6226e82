#include "common/world/snapshot.h"

#include <algorithm>
#include <bit>

namespace padr::world {
namespace {

// A world's kinematics have no -0, so there is nothing to make alike.
std::uint64_t exact(float a, float b) {
  return static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(a)) << 32U | std::bit_cast<std::uint32_t>(b);
}

}  // namespace

void sort_by_key(std::vector<ContactState>& contacts) {
  const auto by_key = [](const ContactState& a, const ContactState& b) { return a.key < b.key; };
  if (!std::is_sorted(contacts.begin(), contacts.end(), by_key)) std::sort(contacts.begin(), contacts.end(), by_key);
}

void add_to_hash(WideHasher& h, const Snapshot& s) {
  const auto word = [](Vec2 v) { return Hasher::word(v.x, v.y); };
  h.add(s.entities.size(), s.contacts.size(), 0, 0);
  for (const Kinematics& k : s.entities)
    h.add(exact(k.position.x, k.position.y), exact(k.velocity.x, k.velocity.y), exact(k.angle, k.spin),
          exact(k.sleep_time, 0) | static_cast<std::uint64_t>(k.awake));
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
