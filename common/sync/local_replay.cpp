#include "common/sync/local_replay.h"

#include <algorithm>

namespace padr::sync {
namespace {

// Beyond this part of all entities, replaying everything is no dearer.
constexpr std::size_t kMostOf = 2;
// So often it begins anew with whom it has met.
constexpr int kMostAttempts = 4;
// So many contacts are looked at in the time of a step of one entity.
constexpr std::size_t kContactsOfAStep = 50;

bool is_order(const Bundle& b) {
  return b.leave || b.spectates || b.going || b.admission || !b.removals.empty() || !b.passed_on.empty() ||
         !b.passages.empty();
}

}  // namespace

// Continuous collision looks at where things go, too, and not only at where they are.
LocalReplay::LocalReplay(const Scene& scene, int slots, bool authority)
    : fold_(scene, slots, 0, authority), never_(scene.continuous), reach_(world::reaches(scene, slots)) {
  contacts_.reserve(fold_.world().usual_contacts());
  left_out_.assign(reach_.size(), false);
  clear();
  fold_.leave_out({}, left_out_);
}

void LocalReplay::clear() {
  concerned_.clear();
  left_out_.assign(reach_.size(), true);
  all_ = never_;
  latest_ = -1;
}

bool LocalReplay::take(EntityId e) {
  if (!left_out_[e]) return false;
  left_out_[e] = false;
  concerned_.push_back(e);
  return true;
}

void LocalReplay::concerns(const Bundle& b) {
  latest_ = std::max(latest_, b.tick);
  if (is_order(b)) all_ = true;
  take(fold_.world().avatar(b.peer));
  for (const BodyUpdate& u : b.bodies) take(u.body);
}

// Whoever touched one of them in the history that is to be replaced, at any time in it, is another one.
bool LocalReplay::gather(const History& history, const UpdateLog& log, Tick from, Tick now) {
  for (Tick t = from; t <= now; ++t)
    if (!history.has(t) || std::any_of(log.at(t).begin(), log.at(t).end(), is_order)) return false;
  for (bool found = true; found;) {
    found = false;
    std::size_t looks = 0;
    const auto join = [&](std::uint32_t key) {
      const EntityId a = world::first_of(key);
      const EntityId b = world::second_of(key);
      if (b >= left_out_.size() || left_out_[a] == left_out_[b]) return;  // fixed, or both or neither
      take(left_out_[a] ? a : b);
      found = true;
    };
    for (Tick t = from; t <= now; ++t) {
      for (const world::ContactState& c : history.at(t).world.contacts) join(c.key);
      for (const std::uint32_t key : history.at(t).world.parted) join(key);
      looks += history.at(t).world.contacts.size();
    }
    spend(looks / kContactsOfAStep);
    if (concerned_.size() * kMostOf > left_out_.size()) return false;
    if (concerned_.size() * static_cast<std::size_t>(now - from) > left_) return false;
  }
  return true;
}

void LocalReplay::spend(std::size_t steps) {
  left_ -= std::min(left_, steps);
}

bool LocalReplay::may_touch(EntityId a, EntityId b) const {
  const world::World& w = fold_.world();
  if (!fold_.is_there(a) || !fold_.is_there(b)) return false;
  if (w.is_avatar(a) == w.is_avatar(b) || !fold_.with_authority()) return true;
  if (w.is_avatar(a)) std::swap(a, b);
  return fold_.holds(static_cast<PeerId>(b - w.bodies()), a);
}

bool LocalReplay::meets(EntityId other, Vec2 there) const {
  return left_out_[other] && std::any_of(concerned_.begin(), concerned_.end(), [&](EntityId mine) {
           return world::within_reach(fold_.world().position(mine), reach_[mine], there, reach_[other]) &&
                  may_touch(mine, other);
         });
}

// Whoever is met is another one of those concerned.
bool LocalReplay::meets_others(const FoldState& others, const std::vector<Bundle>& told) {
  box_.clear();
  for (const EntityId e : concerned_) box_.enclose(fold_.world().position(e), reach_[e]);
  const std::size_t before = concerned_.size();
  const auto look = [&](EntityId e, Vec2 there) {
    if (!box_.is_clear_of(there, reach_[e]) && meets(e, there)) take(e);
  };
  EntityId e = 0;
  for (const world::Kinematics& k : others.world.entities) look(e++, k.position);
  for (const Bundle& b : told) {
    if (b.avatar) look(fold_.world().avatar(b.peer), b.avatar->position);
    for (const BodyUpdate& u : b.bodies)
      if (u.has_state) look(u.body, u.state.position);
  }
  return concerned_.size() > before;
}

bool LocalReplay::run(History& history, const UpdateLog& log, Tick from, Tick now, std::size_t most) {
  left_ = most;
  if (all_) return false;
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    if (!gather(history, log, from, now)) return false;
    if (play(history, log, from, now)) return true;
  }
  return false;
}

// False if somebody is met who is not concerned yet.
bool LocalReplay::play(History& history, const UpdateLog& log, Tick from, Tick now) {
  fold_.restore_part(history.at(from), concerned_, left_out_);
  while (fold_.tick() < now) {
    const std::vector<Bundle>& told = log.at(fold_.tick());
    for (const Bundle& b : told) fold_.apply(b);
    FoldState& next = history.at(fold_.tick() + 1);
    if (meets_others(history.at(fold_.tick()), told)) {
      latest_ = std::max(latest_, fold_.tick());  // so far the history has been written over already
      return false;
    }
    fold_.step();
    spend(concerned_.size());
    ++steps_;
    // Where it comes out as it was, so does all that follows.
    if (!merge(next) && fold_.tick() > latest_) break;
  }
  return true;
}

bool LocalReplay::merge(FoldState& into) {
  bool changed = into.avatars != fold_.avatars() || into.authority != fold_.authority() || into.holds != fold_.holds();
  if (changed) {
    into.avatars = fold_.avatars();
    into.authority = fold_.authority();
    into.holds = fold_.holds();
  }
  for (const EntityId e : concerned_) {
    const world::Kinematics k = fold_.world().kinematics(e);
    changed = changed || k != into.world.entities[e];
    into.world.entities[e] = k;
  }
  contacts_ = into.world.contacts;
  fold_.world().save_contacts(mine_);
  world::replace_contacts(into.world, mine_, left_out_);
  return changed || contacts_ != into.world.contacts;
}

}  // namespace padr::sync
