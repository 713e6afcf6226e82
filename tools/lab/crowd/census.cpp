#include "tools/lab/crowd/census.h"

#include <cmath>

namespace padr::lab {
namespace {

const node::Replica* node_in(const crowd::CrowdPeer& peer, crowd::Region r) {
  for (const crowd::Post& post : peer.posts())
    if (post.region == r) return &post.peer->replica();
  return nullptr;
}

std::optional<Vec2> avatar_as_seen(const node::Replica& n, const Endpoint& of) {
  for (PeerId p = 0; p < n.config().slots; ++p)
    if (p != n.self() && n.seat(p).there() && same_place(n.seat(p).at, of) &&
        n.agreed().predicted_state().avatars[p].present)
      return n.live().world().position(n.live().world().avatar(p));
  return std::nullopt;
}

}  // namespace

void Census::look(const CrowdRun& run) {
  grid_.clear();
  for (int i = 0; i < run.persons(); ++i) {
    if (!run.peer(i).playing()) continue;
    const Vec2 at = run.peer(i).avatar().position;
    grid_[{static_cast<int>(std::floor(at.x / near_)), static_cast<int>(std::floor(at.y / near_))}].push_back(i);
  }
  find_truth(run);
  for (int i = 0; i < run.persons(); ++i) {
    if (!run.peer(i).playing()) continue;
    ++looks_;
    regions_ += run.peer(i).posts().size();
    look_at_avatars(run, i);
    look_at_bodies(run, i);
  }
}

// A body that crosses a border may be owned twice for a moment: the newer one counts.
void Census::find_truth(const CrowdRun& run) {
  bodies_.clear();
  for (int i = 0; i < run.persons(); ++i)
    for (const crowd::Post& post : run.peer(i).posts()) {
      const node::Replica& n = post.peer->replica();
      const sync::FoldState& s = n.agreed().predicted_state();
      for (EntityId b = 0; b < s.residents.slots.size(); ++b) {
        const sync::Resident& who = s.residents.slots[b];
        if (!who.present || s.authority[b].holder() != n.self()) continue;
        Truth& t = bodies_.try_emplace(who.name).first->second;
        if (who.crossings >= t.crossings) t = {n.live().world().position(b), who.crossings};
      }
    }
}

void Census::look_at_avatars(const CrowdRun& run, int person) {
  const Vec2 self = run.peer(person).avatar().position;
  const int x = static_cast<int>(std::floor(self.x / near_));
  const int y = static_cast<int>(std::floor(self.y / near_));
  for (int dx = -1; dx <= 1; ++dx)
    for (int dy = -1; dy <= 1; ++dy) {
      const auto cell = grid_.find({x + dx, y + dy});
      if (cell == grid_.end()) continue;
      for (const int other : cell->second) {
        const Vec2 truth = run.peer(other).avatar().position;
        if (other == person || distance(self, truth) > near_) continue;
        const node::Replica* n = node_in(run.peer(person), run.peer(other).home());
        const auto seen = n != nullptr ? avatar_as_seen(*n, run.place_of(other)) : std::nullopt;
        if (!seen) {
          ++unseen_;
          continue;
        }
        ++avatars_;
        avatar_error_ += distance(*seen, truth);
      }
    }
}

void Census::look_at_bodies(const CrowdRun& run, int person) {
  const Vec2 self = run.peer(person).avatar().position;
  std::map<sync::BodyName, Truth> seen;
  for (const crowd::Post& post : run.peer(person).posts()) {
    const node::Replica& n = post.peer->replica();
    const auto& slots = n.live().residents().slots;
    for (EntityId b = 0; b < slots.size(); ++b) {
      if (!slots[b].present) continue;
      Truth& t = seen.try_emplace(slots[b].name).first->second;
      if (slots[b].crossings >= t.crossings) t = {n.live().world().position(b), slots[b].crossings};
    }
  }
  for (const auto& [name, t] : seen) {
    const auto truth = bodies_.find(name);
    if (truth != bodies_.end() && distance(self, truth->second.position) <= near_)
      body_error_ += distance(t.position, truth->second.position);
  }
}

}  // namespace padr::lab
