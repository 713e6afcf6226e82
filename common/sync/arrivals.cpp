#include "common/sync/arrivals.h"

#include <algorithm>
#include <limits>

#include "common/world/avatar_control.h"

namespace padr::sync {
namespace {

// What is older would be moved through half the world.
constexpr Tick kOldest = 2 * kTicksPerSecond;

void step_model(AvatarUpdate& u, const AvatarDef& avatar) {
  Vec2 v = u.velocity;
  if (u.model == Model::kStatic) v = {};
  if (u.model == Model::kSecond) v = u.velocity = clamp_length(v + u.control * kTickSeconds, avatar.max_speed);
  if (u.model == Model::kInput && !world::has_arrived(u.position, v, u.control))
    v = u.velocity = v + world::control_force(avatar, u.position, v, u.control) * (kTickSeconds / avatar.mass);
  u.position = u.position + v * kTickSeconds;
}

void move_on(Bundle& b, Tick age, const AvatarDef& avatar) {
  for (Tick t = 0; t < age && b.avatar && b.avatar->awake; ++t) step_model(*b.avatar, avatar);
  const float seconds = static_cast<float>(age) * kTickSeconds;
  for (BodyUpdate& u : b.bodies) {
    if (!u.has_state || !u.state.awake) continue;
    u.state.position = u.state.position + u.state.velocity * seconds;
    u.state.angle += u.state.spin * seconds;
  }
}

}  // namespace

Arrivals::Arrivals(int slots, int bodies)
    : first_(static_cast<std::size_t>(slots), 0),
      newest_avatar_(static_cast<std::size_t>(slots), -1),
      newest_body_(static_cast<std::size_t>(slots), std::vector<Tick>(static_cast<std::size_t>(bodies), -1)) {}

void Arrivals::take_back(PeerId peer, std::uint32_t from) {
  std::erase_if(waiting_, [&](const Bundle& b) { return b.peer == peer && b.index >= from; });
}

void Arrivals::apply_to(Fold& fold, bool time_stamps) {
  for (Bundle& b : waiting_) {
    if (b.index < first_[b.peer]) continue;
    keep_newest(b);
    const Tick told = b.tick;
    if (time_stamps) move_on(b, std::clamp(fold.tick() - told, 0, kOldest), fold.world().scene().avatar);
    if (!b.admission) b.tick = fold.tick();  // from an admission's own tick the begin of play is counted
    fold.apply(b, told);
  }
  waiting_.clear();
}

// Takes out of it what is older than what has been here.
void Arrivals::keep_newest(Bundle& b) {
  if (b.leave || b.spectates) newest_avatar_[b.peer] = std::numeric_limits<Tick>::max();
  if (b.admission) {
    first_[b.admission->slot] = b.admission->first;
    newest_avatar_[b.admission->slot] = -1;
    newest_body_[b.admission->slot].assign(newest_body_[b.admission->slot].size(), -1);
  }
  if (b.avatar && b.tick <= newest_avatar_[b.peer] && !b.leave) b.avatar.reset();
  if (b.avatar) newest_avatar_[b.peer] = b.tick;
  std::vector<Tick>& newest = newest_body_[b.peer];
  std::erase_if(b.bodies, [&](const BodyUpdate& u) { return b.tick <= newest[u.body]; });
  for (const BodyUpdate& u : b.bodies) newest[u.body] = b.tick;
}

}  // namespace padr::sync
