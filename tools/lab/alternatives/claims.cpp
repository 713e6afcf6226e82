#include "tools/lab/alternatives/claims.h"

#include "common/model/hash.h"

namespace padr::lab::alternatives {
namespace {

std::uint64_t lot(const Claim& c, EntityId body) {
  Hasher h;
  h.add(static_cast<std::uint64_t>(c.owner));
  h.add(static_cast<std::uint64_t>(body));
  h.add(static_cast<std::uint64_t>(c.sequence));
  return h.value();
}

}  // namespace

bool beats(const Claim& a, const Claim& b, EntityId body) {
  const auto ahead = static_cast<std::int16_t>(static_cast<std::uint16_t>(a.sequence - b.sequence));
  if (ahead != 0) return ahead > 0;
  return a.owner != b.owner && lot(a, body) < lot(b, body);
}

bool ClaimTable::hear(EntityId body, const Claim& told) {
  Claim& c = claims_[body];
  const bool same = told.owner == c.owner && told.sequence == c.sequence;
  if (!same && !beats(told, c, body)) return false;
  c = told;
  return true;
}

void ClaimTable::take(EntityId body) {
  Claim& c = claims_[body];
  c.owner = self_;
  ++c.sequence;
}

void ClaimTable::touch(const world::World& world, EntityId avatar) {
  reached_.assign(claims_.size(), 0);
  for (EntityId b = 0; b < claims_.size(); ++b) {
    if (!mine(b)) continue;
    claims_[b].held = false;
    claims_[b].awake = world.awake(b);
  }
  reach(world, {avatar}, true);
  std::vector<EntityId> thrown;
  for (EntityId b = 0; b < claims_.size(); ++b)
    if (mine(b) && claims_[b].awake && reached_[b] == 0) thrown.push_back(b);
  reach(world, std::move(thrown), false);
}

void ClaimTable::reach(const world::World& world, std::vector<EntityId> frontier, bool by_avatar) {
  while (!frontier.empty()) {
    const EntityId from = frontier.back();
    frontier.pop_back();
    for (const Contact& c : world.contacts()) {
      if (c.first != from && c.second != from) continue;
      const EntityId b = c.first == from ? c.second : c.first;
      if (world.is_avatar(b) || reached_[b] != 0) continue;
      const bool taken_by_others = !mine(b) && (claims_[b].held || (!by_avatar && claims_[b].awake));
      if (taken_by_others) continue;
      reached_[b] = 1;
      if (!mine(b)) take(b);
      claims_[b].held = by_avatar;
      claims_[b].awake = world.awake(b);
      frontier.push_back(b);
    }
  }
}

}  // namespace padr::lab::alternatives
