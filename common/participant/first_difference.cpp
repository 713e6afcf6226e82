#include "common/participant/participant.h"

namespace padr::node {

std::string first_difference(const sync::FoldState& ours, const sync::FoldState& theirs) {
  const std::string where = "differ at tick " + std::to_string(ours.tick);
  const std::size_t bodies = ours.authority.size();
  for (std::size_t e = 0; e < ours.world.entities.size(); ++e) {
    const world::Kinematics& a = ours.world.entities[e];
    const world::Kinematics& b = theirs.world.entities[e];
    const std::string who = (e < bodies ? " body " + std::to_string(e) : " avatar " + std::to_string(e - bodies));
    const auto say = [&](const char* field, float x, float y) {
      return where + " in" + who + "'s " + field + ": " + std::to_string(x) + " here, " + std::to_string(y) + " there";
    };
    if (a.position.x != b.position.x) return say("x (m)", a.position.x, b.position.x);
    if (a.position.y != b.position.y) return say("y (m)", a.position.y, b.position.y);
    if (a.angle != b.angle) return say("angle (rad)", a.angle, b.angle);
    if (a.velocity.x != b.velocity.x) return say("x velocity (m/s)", a.velocity.x, b.velocity.x);
    if (a.velocity.y != b.velocity.y) return say("y velocity (m/s)", a.velocity.y, b.velocity.y);
    if (a.spin != b.spin) return say("spin (rad/s)", a.spin, b.spin);
    if (a.sleep_time != b.sleep_time) return say("sleep time (s)", a.sleep_time, b.sleep_time);
    if (a.awake != b.awake) return where + " in" + who + "'s being awake";
  }
  for (std::size_t b = 0; b < bodies; ++b) {
    if (ours.authority[b] != theirs.authority[b]) return where + " in body " + std::to_string(b) + "'s authority";
    if (ours.holds[b] != theirs.holds[b]) return where + " in the holders of body " + std::to_string(b);
  }
  for (std::size_t b = 0; b < ours.residents.slots.size(); ++b)
    if (ours.residents.slots[b] != theirs.residents.slots[b])
      return where + " in the content of body slot " + std::to_string(b);
  if (ours.residents != theirs.residents) return where + " in the bodies that have gone";
  if (ours.start != theirs.start) return where + " in when play begins";
  if (ours.members != theirs.members) return where + " in the members";
  if (ours.avatars != theirs.avatars) return where + " in an avatar's model";
  if (ours.world.contacts != theirs.world.contacts) return where + " in the contacts' memory";
  return "";
}

}  // namespace padr::node
