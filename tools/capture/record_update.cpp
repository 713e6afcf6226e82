#include "tools/capture/record_update.h"

#include <array>
#include <limits>

#include "common/sync/validation.h"

namespace padr::capture {
namespace {

using sync::Bundle;

constexpr std::array<std::string_view, 4> kModels{"static", "first", "second", "input"};

std::string_view name_of(sync::Cause c) {
  return sync::kCauseNames[static_cast<std::size_t>(c)];
}

void put_avatar(Record& r, const sync::AvatarUpdate& u) {
  const auto model = static_cast<std::size_t>(u.model);
  r.number("padr.avatar.flags", static_cast<unsigned>(u.cause) | model << 3U | (u.awake ? 1U << 5U : 0U) | 1U << 6U);
  r.text("padr.cause", name_of(u.cause));
  r.text("padr.avatar.model", kModels[model]);
  r.flag("padr.avatar.awake", u.awake);
  r.real("padr.avatar.x", u.position.x);
  r.real("padr.avatar.y", u.position.y);
  r.real("padr.avatar.vx", u.velocity.x);
  r.real("padr.avatar.vy", u.velocity.y);
  if (u.model != Model::kSecond && u.model != Model::kInput) return;
  r.real("padr.avatar.control_x", u.control.x);
  r.real("padr.avatar.control_y", u.control.y);
}

void put_body(Record& r, const sync::BodyUpdate& u, PeerId peer, Tick tick) {
  const bool awake = u.has_state && u.state.awake;
  r.number("padr.entity", u.body);
  r.number("padr.body.flags", static_cast<unsigned>(u.cause) | (u.held ? 1U << 3U : 0U) |
                                  (u.has_state ? 1U << 4U : 0U) | (u.release ? 1U << 5U : 0U) |
                                  (awake ? 1U << 6U : 0U));
  r.text("padr.cause", name_of(u.cause));
  r.flag("padr.hold", u.held);
  r.flag("padr.release", u.release);
  r.flag("padr.body.state", u.has_state);
  if (!u.has_state) return;
  r.number("padr.owner", u.release ? kNoPeer : peer);
  r.number("padr.epoch", u.epoch);
  r.number("padr.claim_age", static_cast<std::uint64_t>(tick - u.claimed));
  r.number("padr.claimed", static_cast<std::uint64_t>(u.claimed));
  r.flag("padr.body.awake", awake);
  r.real("padr.body.x", u.state.position.x);
  r.real("padr.body.y", u.state.position.y);
  r.real("padr.body.angle", u.state.angle);
  if (!awake) return;
  r.real("padr.body.vx", u.state.velocity.x);
  r.real("padr.body.vy", u.state.velocity.y);
  r.real("padr.body.spin", u.state.spin);
}

void put_orders(Record& r, const Bundle& b) {
  if (b.admission) {
    const sync::Admission& a = *b.admission;
    r.number("padr.admission.slot", a.slot);
    r.number("padr.admission.incarnation", a.incarnation);
    r.number("padr.admission.first", a.first);
    r.address("padr.admission.address", a.at);
    r.number("padr.admission.port", a.at.port);
    for (const std::uint32_t have : a.have) r.number("padr.admission.have", have);
    r.flag("padr.admission.spectator", a.spectator);
  }
  for (const sync::Removal& m : b.removals) {
    r.number("padr.removal.slot", m.slot);
    r.number("padr.removal.incarnation", m.incarnation);
    r.number("padr.removal.count", m.count);
  }
  for (const Bundle& lost : b.passed_on) {
    r.number("padr.passed_on.slot", lost.peer);
    r.number("padr.passed_on.index", lost.index);
    r.number("padr.passed_on.tick", static_cast<std::uint64_t>(lost.tick));
    put_update(r, lost, lost.tick, lost.index + 1);
  }
}

// What sync::admit looks for besides: that needs no scene and no session.
constexpr std::uint32_t kMostNumber = 1U << 30U;

/// The ranges of every scene: it may have its corners anywhere.
const Scene& any_scene() {
  static const Scene scene = [] {
    constexpr float kFar = std::numeric_limits<float>::infinity();
    Scene s;
    s.lower = {-kFar, -kFar};
    s.upper = {kFar, kFar};
    return s;
  }();
  return scene;
}

bool is_sound(const Bundle& b) {
  if (b.admission)
    if (b.admission->slot == b.peer || b.admission->incarnation == 0 || b.admission->incarnation >= kMostNumber ||
        b.admission->first >= kMostNumber)
      return false;
  for (const sync::Removal& m : b.removals)
    if (m.slot == b.peer || m.incarnation >= kMostNumber || m.count >= kMostNumber) return false;
  for (const Bundle& lost : b.passed_on)
    if (lost.peer == b.peer || lost.index >= kMostNumber || lost.tick > b.tick || !is_sound(lost)) return false;
  for (const sync::BodyUpdate& u : b.bodies)
    if (u.has_state && (u.epoch == 0 || u.epoch > kMostNumber || !sync::believable(u.state, any_scene()))) return false;
  Bundle avatar_alone;
  avatar_alone.avatar = b.avatar;
  return sync::admit(avatar_alone, any_scene(), kMaxPeers) == sync::DropReason::kNone;
}

}  // namespace

void put_update(Record& r, const Bundle& b, Tick mark_tick, std::uint32_t mark_count) {
  r.number("padr.update.index_back", mark_count - 1 - b.index);
  r.number("padr.update.tick_back", static_cast<std::uint64_t>(mark_tick - b.tick));
  r.number("padr.update.peer", b.peer);
  r.number("padr.update.index", b.index);
  r.number("padr.update.tick", static_cast<std::uint64_t>(b.tick));
  if (b.leave) r.flag("padr.update.leave", true);
  if (b.spectates) r.flag("padr.update.spectates", true);
  if (b.signature) r.bytes("padr.update.signature", *b.signature);
  if (b.avatar) put_avatar(r, *b.avatar);
  for (const sync::BodyUpdate& u : b.bodies) put_body(r, u, b.peer, b.tick);
  put_orders(r, b);
}

std::string_view drop_of(const std::vector<Bundle>& updates) {
  for (std::size_t i = 1; i < updates.size(); ++i)
    if (updates[i].index <= updates[i - 1].index || updates[i].tick <= updates[i - 1].tick) return "order";
  for (const Bundle& b : updates)
    if (!is_sound(b)) return "value";
  return "";
}

}  // namespace padr::capture
