#include "tools/lab/crowd/body_positions.h"

#include <map>
#include <set>

namespace padr::lab {

BodyPositions inventory_of(const CrowdRun& run, const crowd::Plane& plane) {
  BodyPositions inv;
  std::map<sync::BodyName, int> found;
  std::set<std::uint32_t> ours;
  for (const auto& [region, members] : run.members()) {
    ++inv.regions;
    ours.insert(crowd::id_of(region));
    for (const crowd::Post& post : run.peer(members.front()).posts()) {
      if (post.region != region) continue;
      for (const sync::Resident& r : post.peer->replica().agreed().confirmed().residents.slots) {
        if (!r.present) continue;
        if (found[r.name]++ > 0) ++inv.doubled;
        if (r.name.region != crowd::id_of(region)) ++inv.abroad;
      }
    }
  }
  inv.bodies = found.size();
  for (const std::uint32_t region : ours)
    for (int b = 0; b < plane.bodies; ++b)
      if (!found.contains({region, static_cast<std::uint16_t>(b)})) ++inv.lost;
  return inv;
}

}  // namespace padr::lab
