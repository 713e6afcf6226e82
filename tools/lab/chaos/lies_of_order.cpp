// Behaviours of a liar: orders that are not its to give, and updates that nobody has said.
#include <algorithm>

#include "tools/lab/chaos/lies.h"

namespace padr::lab {
namespace {

using sync::Bundle;
using sync::StatePacket;

/// Chance that an update becomes an order: about one in two seconds.
constexpr double kOrders = 0.05;

sync::Removal removal_of(const Deceiver& d, PeerId p) {
  return {p, d.replica().seat(p).incarnation, d.replica().agreed().log().have(p)};
}

std::vector<sync::Removal> removals_of_all(const Deceiver& d) {
  std::vector<sync::Removal> all;
  for (PeerId p = 0; p < d.replica().config().slots; ++p)
    if (p != d.replica().self() && d.replica().seat(p).there()) all.push_back(removal_of(d, p));
  return all;
}

/// Everybody but the one who is asked is asked about these.
wire::Poll freezing(const Deceiver& d, const std::vector<sync::Removal>& whom, PeerId asked) {
  wire::Poll poll{{}, true, 0};
  for (const sync::Removal& r : whom)
    if (r.slot != asked && r.slot != d.replica().self()) poll.lost.push_back({r.slot, r.incarnation});
  return poll;
}

Endpoint nowhere(Rng& rng) {
  Endpoint at = ipv4({192, 0, 2, static_cast<std::uint8_t>(1 + rng.below(250))}, 9);
  at.key.fill(static_cast<std::uint8_t>(1 + rng.below(250)));
  return at;
}

sync::Admission puppet(Deceiver& d, bool taken) {
  const node::Roster& r = d.replica().roster();
  sync::Admission a;
  a.slot = d.victim();
  for (PeerId p = 0; !taken && p < r.slots(); ++p)
    if (p != r.self && !r.seats[p].reachable()) a.slot = p;
  a.incarnation = r.newest_incarnation() + node::kMostIncarnationStep;
  a.first = d.replica().agreed().log().have(a.slot);
  a.at = nowhere(d.rng);
  for (PeerId p = 0; p < r.slots(); ++p) a.have.push_back(d.replica().agreed().log().have(p));
  return a;
}

/// What the victim has not said, or has not said so.
Bundle invented(Deceiver& d, Tick before) {
  const PeerId whose = d.victim();
  const sync::UpdateLog& log = d.replica().agreed().log();
  const std::uint32_t have = log.have(whose);
  const std::vector<Bundle> latest = log.of(whose, have > 3 ? have - 3 : 0);
  Bundle b;
  if (!latest.empty() && d.rng.chance(0.5)) b = latest.back();
  b.passed_on.clear();
  b.peer = whose;
  b.index = have + d.rng.below(3);
  b.tick = std::min(before, std::max(b.tick, 0));
  b.avatar = sync::AvatarUpdate{};
  b.avatar->position = {3, 3};
  d.liar.sign(b, d.replica().seat(whose).incarnation);
  return b;
}

}  // namespace

void lie_with_removals(const Plot& plot) {
  const bool all = plot->variant % 3 == 2;
  const auto whom = [plot, all] {
    return all ? removals_of_all(*plot) : std::vector{removal_of(*plot, plot->victim())};
  };
  Rewriting rewriting(plot, [plot, whom](const Bundle& b) -> std::optional<Bundle> {
    if (plot->victim() == kNoPeer || !plot->rng.chance(kOrders)) return std::nullopt;
    Bundle lie = emptied(b);
    lie.removals = whom();
    return lie;
  });
  plot->liar.begin([rewriting](StatePacket& p, PeerId) mutable { rewriting(p); });
  if (plot->variant % 3 == 0) return;
  plot->liar.send_too([plot, whom](const wire::Header&, PeerId to) {
    std::vector<wire::Bytes> out;
    if (!plot->active || plot->victim() == kNoPeer || !plot->rng.chance(0.1)) return out;
    const wire::Poll poll = freezing(*plot, whom(), to);
    if (!poll.lost.empty()) out.push_back(plot->said(poll));
    return out;
  });
}

void lie_with_orders_to_some(const Plot& plot) {
  Rewriting rewriting(plot, [plot](const Bundle& b) -> std::optional<Bundle> {
    if (plot->victim() == kNoPeer || !plot->rng.chance(kOrders)) return std::nullopt;
    Bundle lie = emptied(b);
    if (plot->variant % 2 == 0)
      lie.removals = {removal_of(*plot, plot->victim())};
    else
      lie.admission = puppet(*plot, false);
    return lie;
  });
  plot->liar.begin([rewriting](StatePacket& p, PeerId to) mutable {
    StatePacket lie = p;
    rewriting(lie);
    if (Deceiver::is_other_half(to)) p = lie;
  });
  plot->liar.send_too([plot](const wire::Header&, PeerId to) {
    std::vector<wire::Bytes> out;
    if (!plot->active || !Deceiver::is_other_half(to) || plot->victim() == kNoPeer || !plot->rng.chance(0.1))
      return out;
    const wire::Poll poll = freezing(*plot, {removal_of(*plot, plot->victim())}, to);
    if (!poll.lost.empty()) out.push_back(plot->said(poll));
    return out;
  });
}

void lie_with_admissions(const Plot& plot) {
  Rewriting rewriting(plot, [plot](const Bundle& b) -> std::optional<Bundle> {
    if (plot->victim() == kNoPeer || !plot->rng.chance(kOrders)) return std::nullopt;
    Bundle lie = emptied(b);
    lie.admission = puppet(*plot, plot->variant % 2 == 0);
    return lie;
  });
  plot->liar.begin([rewriting](StatePacket& p, PeerId) mutable { rewriting(p); });
}

void lie_with_relays(const Plot& plot) {
  Rewriting rewriting(plot, [plot](const Bundle& b) -> std::optional<Bundle> {
    if (plot->victim() == kNoPeer || !plot->rng.chance(kOrders)) return std::nullopt;
    Bundle lie = emptied(b);
    lie.passed_on = {invented(*plot, b.tick - 1)};
    return lie;
  });
  plot->liar.begin([rewriting](StatePacket& p, PeerId) mutable { rewriting(p); });
  plot->liar.speak_of_others([plot](wire::MembershipMessage& m) {
    auto* fetched = std::get_if<wire::Fetched>(&m);
    if (fetched == nullptr || !plot->active) return;
    for (Bundle& b : fetched->updates) {
      b.avatar = sync::AvatarUpdate{};
      b.avatar->position = {3, 3};
    }
  });
  plot->liar.send_too([plot](const wire::Header&, PeerId to) {
    std::vector<wire::Bytes> out;
    const PeerId about = plot->victim();
    if (!plot->active || about == kNoPeer) return out;
    const std::uint32_t incarnation = plot->replica().seat(about).incarnation;
    for (int i = 0; i < 4 && about != to; ++i) out.push_back(plot->said(wire::Fetch{about, incarnation, 0}));
    if (plot->rng.chance(0.2))
      out.push_back(plot->said(wire::Fetched{about, incarnation, {invented(*plot, plot->replica().now())}}));
    return out;
  });
}

}  // namespace padr::lab
