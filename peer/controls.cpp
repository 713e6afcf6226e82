#include "peer/controls.h"

#include <algorithm>

#include "common/model/user_error.h"
#include "shell/netem_flags.h"
#include "shell/netem_text.h"
#include "shell/technique_text.h"
#include "shell/text.h"

namespace padr::peer {
namespace {

using monitor::EventKind;

std::string seconds_text(float seconds) {
  return "for " + shell::fixed(static_cast<double>(seconds), 1) + " s";
}

std::string cut_text(const monitor::Cut& c) {
  constexpr std::array<const char*, 3> kWhat{"", ", what goes there", ", what comes from there"};
  return seconds_text(c.seconds) + kWhat[static_cast<std::size_t>(c.ways)];
}

Technique turned(const Technique& now, const monitor::Knob& k) {
  if (k.name == "technique") return technique_by_name(k.value);
  const auto knobs = shell::knobs();
  const auto found =
      std::find_if(knobs.begin(), knobs.end(), [&k](const shell::Knob& one) { return one.flag == "--" + k.name; });
  if (found == knobs.end()) throw UserError("--" + k.name + ": there is no such knob");
  Technique t = now;
  found->set(t, k.value);
  return t;
}

}  // namespace

void Controls::obey(const monitor::Order& order, Micros now) {
  now_ = now;
  try {
    if (!player_.playing() || player_.leaving()) throw UserError("this peer does not play");
    std::visit([&](const auto& what) { follow(what, order.number, now); }, order.what);
  } catch (const UserError& e) {
    say(EventKind::kRefused, order.number, kNoPeer, e.what());
  }
}

void Controls::follow(const monitor::Drive& d, std::uint32_t order, Micros now) {
  telemetry_.drives(order);
  player_.drive(d, now);
}

void Controls::follow(const monitor::Knob& k, std::uint32_t order, Micros /*now*/) {
  const Technique t = turned(player_.technique(), k);
  if (t.authority != player_.technique().authority)
    throw UserError("--" + k.name + ": '" + k.value + "' has another rule of authority than the session");
  player_.retune(t);
  say(EventKind::kKnob, order, kNoPeer, "--" + k.name + " " + k.value);
}

void Controls::follow(const monitor::Netem& n, std::uint32_t order, Micros now) {
  const std::optional<PeerId> to = other(n.to);
  const link::NetemSpec spec = shell::parse_netem_field("netem", n.spec, nullptr);
  egress_.impair(to, spec, now);
  const std::string text = shell::to_string(spec);
  player_.remark({"netem", n.to, text});
  say(EventKind::kNetem, order, n.to, text.empty() ? "unimpaired" : text);
}

void Controls::follow(const monitor::Cut& c, std::uint32_t order, Micros now) {
  const std::optional<PeerId> peer = other(c.peer);
  std::vector<Endpoint> places;
  if (peer) places = {player_.replica().seat(*peer).at, player_.place(*peer)};
  cuts_.cut(peer, std::move(places), now + in_micros(c.seconds), c.ways);
  player_.remark({"cut", c.peer, cut_text(c)});
  say(EventKind::kCut, order, c.peer, cut_text(c));
  update(now);
}

void Controls::follow(const monitor::Pause& p, std::uint32_t order, Micros now) {
  if (p.seconds > 0) {
    player_.remark({"pause", kNoPeer, seconds_text(p.seconds)});
    say(EventKind::kPause, order, kNoPeer, seconds_text(p.seconds));
    was_paused_ = true;
  } else {
    say(EventKind::kPauseEnd, order, kNoPeer, "");
    was_paused_ = false;
  }
  player_.pause(now + in_micros(p.seconds), now);
}

void Controls::follow(const monitor::Push& p, std::uint32_t order, Micros /*now*/) {
  const node::Replica& replica = player_.replica();
  if (p.body >= replica.live().world().bodies()) throw UserError("body " + std::to_string(p.body) + ": there is none");
  if (!replica.playing()) throw UserError("body " + std::to_string(p.body) + ": play has not begun");
  if (!replica.may_push(p.body))
    throw UserError("body " + std::to_string(p.body) + ": another peer holds it, or has just won it");
  player_.push(p.body, p.velocity);
  say(EventKind::kPush, order, kNoPeer, "by " + shell::fixed(static_cast<double>(length(p.velocity)), 1) + " m/s",
      p.body);
}

std::optional<PeerId> Controls::other(PeerId p) const {
  if (p == kNoPeer) return std::nullopt;
  if (p >= player_.replica().config().slots || p == player_.self() || !player_.replica().seat(p).at.is_set())
    throw UserError("there is no other peer " + std::to_string(p));
  return p;
}

void Controls::update(Micros now) {
  now_ = now;
  for (const PeerId p : cuts_.take_over(now)) say(EventKind::kCutEnd, 0, p, "");
  if (was_paused_ && !player_.paused()) say(EventKind::kPauseEnd, 0, kNoPeer, "");
  was_paused_ = player_.paused();
}

void Controls::say(EventKind kind, std::uint32_t order, PeerId peer, const std::string& text, EntityId entity) {
  const Tick tick = player_.playing() ? player_.replica().now() : 0;
  telemetry_.say({0, tick, kind, entity, peer, order, text});
  if (!limit_.pass(now_)) return;
  const auto& name = monitor::kEventNames[static_cast<std::size_t>(kind)];
  log_.play->info("order {}: {}{}{}", order, name, text.empty() ? "" : ": ", text);
}

}  // namespace padr::peer
