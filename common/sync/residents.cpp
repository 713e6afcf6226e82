#include "common/sync/residents.h"

#include <algorithm>

namespace padr::sync {

std::optional<EntityId> Residents::find(BodyName name) const {
  for (EntityId b = 0; b < slots.size(); ++b)
    if (slots[b].present && slots[b].name == name) return b;
  return std::nullopt;
}

std::uint32_t Residents::newest(BodyName name) const {
  std::uint32_t most = 0;
  for (const Resident& r : slots)
    if (r.present && r.name == name) most = r.crossings;
  for (const Gone& g : gone)
    if (g.name == name) most = std::max(most, g.crossings);
  return most;
}

std::optional<EntityId> Residents::slot_for(const Passage& p, const RegionDef& region) const {
  const auto later = [&p](const Gone& g) { return g.name == p.name && g.crossings >= p.crossings; };
  if (std::any_of(gone.begin(), gone.end(), later)) return std::nullopt;
  if (const auto b = find(p.name)) return slots[*b].crossings < p.crossings ? b : std::nullopt;
  for (EntityId b = 0; b < slots.size(); ++b)
    if (!slots[b].present && region.builds[b] == p.build) return b;
  return std::nullopt;
}

std::optional<EntityId> Residents::slot_of(const Passage& p) const {
  const auto b = find(p.name);
  return b && slots[*b].crossings < p.crossings ? b : std::nullopt;
}

void Residents::note_gone(const Passage& p, Tick now) {
  std::erase_if(gone, [&](const Gone& g) { return g.name == p.name || now - g.at > kRemembered; });
  if (gone.size() == kMostGone) gone.erase(gone.begin());
  gone.push_back({p.name, p.crossings, now});
}

Residents residents_of(const Scene& scene) {
  Residents r;
  if (!scene.region) return r;
  r.slots.resize(scene.bodies.size());
  for (EntityId b = 0; b < r.slots.size(); ++b)
    if (scene.region->empty[b] == 0) r.slots[b] = {true, {scene.region->id, b}, 0, 0};
  return r;
}

void add_to_hash(WideHasher& h, const Residents& r) {
  const auto word = [](BodyName n) { return static_cast<std::uint64_t>(n.region) << 32U | n.number; };
  h.add(r.slots.size(), r.gone.size(), 0, 0);
  for (const Resident& s : r.slots)
    h.add(word(s.name), s.crossings, static_cast<std::uint64_t>(s.present), static_cast<std::uint64_t>(s.bound));
  for (const Residents::Gone& g : r.gone) h.add(word(g.name), g.crossings, static_cast<std::uint64_t>(g.at), 0);
}

}  // namespace padr::sync
