// Behaviours of a liar: what it says in its state datagrams about itself and the world.
#include <algorithm>
#include <limits>
#include <set>

#include "tools/lab/chaos/lies.h"

namespace padr::lab {
namespace {

using sync::Bundle;
using sync::StatePacket;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

const Scene& scene_of(const Deceiver& d) {
  return d.replica().live().world().scene();
}

sync::AvatarUpdate avatar_at(Vec2 position, Vec2 velocity = {}) {
  sync::AvatarUpdate u;
  u.position = position;
  u.velocity = velocity;
  return u;
}

/// A claim that nothing is wrong with but what is put into it.
sync::BodyUpdate claim(const Deceiver& d, EntityId body, Tick tick, std::uint32_t above) {
  sync::BodyUpdate u;
  u.body = body;
  u.held = true;
  u.has_state = true;
  u.epoch = d.replica().agreed().confirmed().authority[body].epoch + above;
  u.claimed = tick;
  u.state.position = {5, 5};
  u.state.awake = true;
  return u;
}

Bundle with_wrong_value(Deceiver& d, const Bundle& b) {
  Bundle lie = emptied(b);
  switch (d.rng.below(7)) {
    case 0:
      lie.avatar = avatar_at({kNan, 1});
      break;
    case 1:
      lie.avatar = avatar_at({1, 1e6F});
      break;
    case 2:
      lie.avatar = avatar_at({1, 1}, {500, 0});
      break;
    case 3:
      lie.avatar = avatar_at({1, 1}, {1, kInfinity});
      break;
    case 4:
      lie.bodies = {claim(d, 0, b.tick, 1U << 30U)};
      break;
    case 5:
      lie.bodies = {claim(d, 0, b.tick, 1)};
      lie.bodies[0].body = 5000;
      break;
    default:
      lie.bodies = {claim(d, 0, b.tick, 1)};
      lie.bodies[0].state.angle = kNan;
  }
  return lie;
}

/// Which of two stories each member is told, and which updates are missing in the second.
class SecondLog {
 public:
  explicit SecondLog(Plot plot) : plot_(std::move(plot)) {}

  void operator()(StatePacket& p, PeerId to) {
    if (!begun_ || p.incarnation != incarnation_) {
      left_out_.clear();
      incarnation_ = p.incarnation;
      newest_ = p.mark_count;
      begun_ = true;
    }
    for (const Bundle& b : p.updates)
      if (plot_->active && b.index > newest_ && plot_->rng.chance(0.1)) left_out_.insert(b.index);
    for (const Bundle& b : p.updates) newest_ = std::max(newest_, b.index);
    if (!Deceiver::is_other_half(to)) return;
    std::erase_if(p.updates, [this](const Bundle& b) { return left_out_.contains(b.index); });
    for (Bundle& b : p.updates) b.index -= missing_below(b.index);
    p.mark_count -= missing_below(p.mark_count);
  }

 private:
  std::uint32_t missing_below(std::uint32_t index) const {
    return static_cast<std::uint32_t>(std::distance(left_out_.begin(), left_out_.lower_bound(index)));
  }
  Plot plot_;
  std::uint32_t incarnation_ = 0;
  std::uint32_t newest_ = 0;
  bool begun_ = false;
  std::set<std::uint32_t> left_out_;
};

}  // namespace

void lie_with_values(const Plot& plot) {
  Rewriting rewriting(plot, [plot](const Bundle& b) {
    return plot->rng.chance(0.3) ? std::optional(with_wrong_value(*plot, b)) : std::nullopt;
  });
  plot->liar.begin([rewriting](StatePacket& p, PeerId) mutable { rewriting(p); });
}

// What nobody has taken need not stay as it was.
void lie_with_signatures(const Plot& plot) {
  plot->liar.begin([plot](StatePacket& p, PeerId) {
    plot->liar.signs = !plot->active;
    if (!plot->active) return;
    for (Bundle& b : p.updates)
      if (b.avatar) b.avatar->position.x += 0.5F;
  });
}

void lie_far_ahead(const Plot& plot) {
  plot->liar.begin([plot](StatePacket& p, PeerId) {
    if (!plot->active || !plot->rng.chance(0.3)) return;
    Bundle b;
    b.peer = plot->replica().self();
    b.index = p.mark_count + plot->rng.below(4000);
    b.tick = p.mark_tick + 1;
    b.avatar = avatar_at({3, 3});
    p.updates.push_back(b);
    p.mark_tick = b.tick;
    p.mark_count = b.index + 1;
  });
}

void lie_by_withholding(const Plot& plot) {
  if (plot->variant % 3 == 0) {
    plot->liar.withhold([plot](wire::Kind, const Endpoint& place, PeerId to) {
      if (!plot->active || !plot->self.playing()) return false;
      const PeerId victim = plot->victim();
      return victim != kNoPeer && (to == victim || place == plot->replica().seat(victim).at);
    });
    return;
  }
  const bool promises = plot->variant % 3 == 1;
  plot->liar.begin([plot, promises](StatePacket& p, PeerId) {
    if (!plot->active) return;
    if (promises)
      p.mark_count += 5;
    else
      p.updates.clear();
  });
}

void lie_with_acks(const Plot& plot) {
  plot->liar.begin([plot](StatePacket& p, PeerId) {
    if (!plot->active) return;
    p.have = p.have_beyond = 0;
    if (plot->variant % 2 == 0) p.seen_seq = p.seen_age = 0;
  });
}

void lie_with_two_logs(const Plot& plot) {
  if (plot->variant % 2 == 0) {
    plot->liar.begin([log = SecondLog(plot)](StatePacket& p, PeerId to) mutable { log(p, to); });
    return;
  }
  plot->liar.begin([plot](StatePacket& p, PeerId to) {
    if (!plot->active || !Deceiver::is_other_half(to)) return;
    p.mark_tick += 60;  // without an update until then, which is not so
    p.check_tick = -1;
  });
}

void lie_by_equivocation(const Plot& plot) {
  Rewriting rewriting(plot, [plot](const Bundle& b) {
    Bundle lie = b;
    if (lie.avatar) lie.avatar->position.x += 0.5F;
    for (sync::BodyUpdate& u : lie.bodies) u.held = !u.held;
    return std::optional(lie);
  });
  plot->liar.begin([rewriting](StatePacket& p, PeerId to) mutable {
    StatePacket lie = p;
    rewriting(lie);
    if (Deceiver::is_other_half(to)) p = lie;
  });
}

void lie_with_hashes(const Plot& plot) {
  plot->liar.begin([plot](StatePacket& p, PeerId to) {
    if (!plot->active || p.check_tick < 0) return;
    if (plot->variant % 2 == 0 || to == plot->victim()) p.check_hash ^= 2;
  });
}

void lie_with_epochs(const Plot& plot) {
  const std::uint32_t above = plot->variant % 2 == 0 ? 100 : (1U << 20U) - 1;
  Rewriting rewriting(plot, [plot, above](const Bundle& b) {
    Bundle lie = b;
    lie.bodies.clear();
    const auto bodies = static_cast<EntityId>(std::min<std::size_t>(scene_of(*plot).bodies.size(), 12));
    for (EntityId body = 0; body < bodies; ++body) lie.bodies.push_back(claim(*plot, body, b.tick, above));
    return std::optional(lie);
  });
  plot->liar.begin([plot, rewriting](StatePacket& p, PeerId to) mutable {
    StatePacket lie = p;
    rewriting(lie);
    if (to == plot->victim()) p = lie;
  });
}

void lie_with_teleports(const Plot& plot) {
  Rewriting rewriting(plot, [plot](const Bundle& b) {
    Bundle lie = b;
    if (lie.avatar) lie.avatar->position = some_place(plot->rng, scene_of(*plot));
    for (sync::BodyUpdate& u : lie.bodies)
      if (u.has_state) u.state.position = some_place(plot->rng, scene_of(*plot));
    return std::optional(lie);
  });
  plot->liar.begin([rewriting](StatePacket& p, PeerId) mutable { rewriting(p); });
}

void lie_about_time(const Plot& plot) {
  plot->liar.begin([plot](StatePacket& p, PeerId) {
    if (!plot->active) return;
    p.transit = plot->variant % 2 == 0 ? 20'000 : -20'000;
    if (plot->variant % 2 == 0) {
      p.mark_tick += 100;
    } else if (p.updates.empty()) {
      p.mark_tick = std::max(0, p.mark_tick - 240);
    }
    p.check_tick = -1;
  });
  plot->liar.speak_to_joiners([plot](wire::SessionMessage& m) {
    auto* pong = std::get_if<wire::Pong>(&m);
    if (pong == nullptr || !plot->active) return;
    constexpr Micros kOff = 3 * kMicrosPerSecond;
    pong->session = std::max<Micros>(0, pong->session + (plot->variant % 2 == 0 ? kOff : -kOff));
  });
}

void lie_with_farewells(const Plot& plot) {
  const bool says_none = plot->variant % 3 == 2;
  Rewriting rewriting(plot, [plot, says_none](const Bundle& b) -> std::optional<Bundle> {
    if (says_none) return b.leave ? std::optional(emptied(b)) : std::nullopt;
    if (!plot->rng.chance(0.05)) return std::nullopt;
    Bundle lie = emptied(b);
    lie.leave = true;
    return lie;
  });
  plot->liar.begin([plot, rewriting](StatePacket& p, PeerId to) mutable {
    StatePacket lie = p;
    rewriting(lie);
    if (plot->variant % 3 != 1 || Deceiver::is_other_half(to)) p = lie;
  });
}

}  // namespace padr::lab
