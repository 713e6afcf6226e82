#include "common/world/bounding_radius.h"

#include <algorithm>

namespace padr::world {
namespace {

// Box2D gives polygons a skin of 1 cm and lets shapes touch as soon as their skins do; the rest is for rounding.
constexpr float kSkin = 0.03F;  // m

float reach_of(const BodyDef& d) {
  return (d.shape == ShapeKind::kCircle ? d.radius : length(d.half)) + kSkin;
}

}  // namespace

std::vector<float> reaches(const Scene& scene, int slots) {
  std::vector<float> all;
  for (const BodyDef& d : scene.bodies) all.push_back(reach_of(d));
  all.resize(all.size() + static_cast<std::size_t>(slots), scene.avatar.radius + kSkin);
  return all;
}

void replace_contacts(Snapshot& into, const Snapshot& part, const std::vector<bool>& left_out) {
  const auto is_replaced = [&left_out](std::uint32_t key) {
    const auto is_in = [&left_out](EntityId e) { return e < left_out.size() && !left_out[e]; };
    return is_in(first_of(key)) || is_in(second_of(key));
  };
  std::erase_if(into.contacts, [&](const ContactState& c) { return is_replaced(c.key); });
  std::erase_if(into.parted, is_replaced);
  if (!part.contacts.empty()) {
    into.contacts.insert(into.contacts.end(), part.contacts.begin(), part.contacts.end());
    sort_by_key(into.contacts);
  }
  into.parted.insert(into.parted.end(), part.parted.begin(), part.parted.end());
}

}  // namespace padr::world
