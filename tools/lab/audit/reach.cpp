#include "tools/lab/audit/reach.h"

#include <algorithm>
#include <limits>

#include "tools/lab/audit/margins.h"

namespace padr::lab::audit {
namespace {

float gap(const Limits& limits, const Place& a, const Place& b) {
  const float between = distance(a.at, b.at) - limits.reach(a.entity) - limits.reach(b.entity);
  return std::max(between - a.unsure - b.unsure, 0.0F);
}

struct Link {
  Place place;
  float missing = std::numeric_limits<float>::max();
};

}  // namespace

// Dijkstra's shortest ways.
std::vector<Measure> judge_claims(const Limits& limits, const Surroundings& around, const std::vector<Place>& own,
                                  const std::vector<Place>& claims) {
  std::vector<Link> open;
  open.reserve(claims.size());
  for (const Place& c : claims) open.push_back({c});
  for (EntityId b = 0; b < around.bodies(); ++b)
    if (around.is_stirred(b)) open.push_back({{b, around.position(b), around.moves_within(b)}});
  for (Link& l : open)
    for (const Place& o : own)
      if (o.entity != l.place.entity) l.missing = std::min(l.missing, gap(limits, o, l.place));
  std::vector<Measure> all(claims.size(), {Kind::kClaim, 0, kClaimGaps});
  while (!open.empty()) {
    const auto next =
        std::min_element(open.begin(), open.end(), [](const Link& a, const Link& b) { return a.missing < b.missing; });
    const Link found = *next;
    open.erase(next);
    for (std::size_t i = 0; i < claims.size(); ++i)
      if (claims[i].entity == found.place.entity && claims[i].at == found.place.at) all[i].measured = found.missing;
    for (Link& l : open) l.missing = std::min(l.missing, found.missing + gap(limits, found.place, l.place));
  }
  return all;
}

}  // namespace padr::lab::audit
