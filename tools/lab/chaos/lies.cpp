#include "tools/lab/chaos/lies.h"

#include <algorithm>
#include <array>

namespace padr::lab {
namespace {

constexpr std::array<Behaviour, 20> kBehaviours{{
    {"values", "says what nobody can compute with: not finite, outside the world, too fast, no such body",
     lie_with_values},
    {"signatures", "changes its updates without signing them anew", lie_with_signatures},
    {"far-ahead", "numbers updates far ahead of those that it has told", lie_far_ahead},
    {"withhold", "tells one member nothing, or nobody its updates, or promises updates that there are none of",
     lie_by_withholding},
    {"acks", "acknowledges nothing, or no updates", lie_with_acks},
    {"two-logs", "leaves updates out for half of the members and numbers the rest anew, or tells them other marks",
     lie_with_two_logs},
    {"equivocation", "tells half of the members other updates of the same numbers", lie_by_equivocation},
    {"hashes", "tells all, or one, wrong hashes of its confirmed world", lie_with_hashes},
    {"epochs", "claims all bodies at high epochs, to one member only", lie_with_epochs},
    {"teleports", "its avatar and what it owns jump about, the same for all", lie_with_teleports},
    {"clocks", "its marks are ahead or behind, and joiners are told another time", lie_about_time},
    {"farewells", "says goodbye to all or to half of the members and stays, or leaves without a goodbye",
     lie_with_farewells},
    {"removals", "declares members gone: without asking, after asking, or all at once", lie_with_removals},
    {"some-orders", "asks half of the members about one, and tells only them that it is gone", lie_with_orders_to_some},
    {"admissions", "admits puppets with high incarnations, or somebody to a taken slot", lie_with_admissions},
    {"relays", "passes on updates that nobody has said, and floods others with requests for updates", lie_with_relays},
    {"probes", "sends members Probes for a part of the session that it invents, in turn with its true list",
     lie_with_probes},
    {"answers", "when asked about a silent peer: hears it for ever, hears nobody, has updates that it cannot show",
     lie_with_answers},
    {"polls", "asks all to freeze a member, takes it back, and asks again", lie_with_polls},
    {"hosts", "refuses joiners, sends them on to nowhere, or gives them a corrupt or endless transfer", lie_to_joiners},
}};

/// To compare with: what chaos does by itself.
constexpr Behaviour kNone{"none", "is honest, for comparison; never drawn", [](const Plot&) {}};

/// Updates that are remembered as told; no honest member lacks older ones.
constexpr std::size_t kRemembered = 4000;

}  // namespace

std::span<const Behaviour> behaviours() {
  return kBehaviours;
}

const Behaviour* behaviour(std::string_view name) {
  if (name == kNone.name) return &kNone;
  const auto it =
      std::find_if(kBehaviours.begin(), kBehaviours.end(), [name](const Behaviour& b) { return b.name == name; });
  return it == kBehaviours.end() ? nullptr : &*it;
}

std::string help_on_behaviours() {
  std::string text;
  const auto line = [&text](const Behaviour& b) {
    std::string name(b.name);
    name.resize(14, ' ');
    text += "  " + name + std::string(b.what) + "\n";
  };
  for (const Behaviour& b : kBehaviours) line(b);
  line(kNone);
  return text;
}

PeerId Deceiver::victim() {
  const node::Roster& r = replica().roster();
  if (victim_ != kNoPeer && victim_ != r.self && victim_ < r.slots() && r.seats[victim_].there()) return victim_;
  std::vector<PeerId> there;
  for (PeerId p = 0; p < r.slots(); ++p)
    if (p != r.self && r.seats[p].there()) there.push_back(p);
  victim_ = there.empty() ? kNoPeer : there[rng.below(static_cast<std::uint32_t>(there.size()))];
  return victim_;
}

wire::Bytes Deceiver::said(const wire::MembershipMessage& message) const {
  const node::ReplicaConfig& c = replica().config();
  return wire::seal({wire::Kind::kMembership, c.self, c.session}, wire::encode_membership(message));
}

void Rewriting::operator()(sync::StatePacket& packet) {
  if (!begun_ || packet.incarnation != incarnation_) {
    said_.clear();
    incarnation_ = packet.incarnation;
    first_ = packet.mark_count;
    begun_ = plot_->active;
  }
  for (sync::Bundle& b : packet.updates)
    if (const auto& fate = fate_of(b)) b = *fate;
}

const std::optional<sync::Bundle>& Rewriting::fate_of(const sync::Bundle& b) {
  static const std::optional<sync::Bundle> kAsItIs;
  if (!begun_ || b.index < first_) return kAsItIs;
  const auto known = said_.find(b.index);
  if (known != said_.end()) return known->second;
  if (said_.size() == kRemembered) said_.erase(said_.begin());
  return said_[b.index] = plot_->active ? choice_(b) : std::nullopt;
}

sync::Bundle emptied(const sync::Bundle& b) {
  sync::Bundle e;
  e.peer = b.peer;
  e.index = b.index;
  e.tick = b.tick;
  return e;
}

Vec2 some_place(Rng& rng, const Scene& scene) {
  return {static_cast<float>(rng.uniform(scene.lower.x, scene.upper.x)),
          static_cast<float>(rng.uniform(scene.lower.y, scene.upper.y))};
}

}  // namespace padr::lab
