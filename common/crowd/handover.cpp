#include "common/crowd/handover.h"

#include <algorithm>

#include "common/model/precision.h"
#include "common/sync/validation.h"

namespace padr::crowd {
namespace {

const Post* post_in(const std::vector<Post>& posts, Region r) {
  const auto it = std::find_if(posts.begin(), posts.end(), [r](const Post& p) { return p.region == r; });
  return it == posts.end() ? nullptr : &*it;
}

bool is_member(const node::Replica& n, const Endpoint& at) {
  for (PeerId p = 0; p < n.config().slots; ++p)
    if (p != n.self() && n.seat(p).there() && same_place(n.seat(p).at, at)) return true;
  return false;
}

/// How many members of both regions come before this peer in the order: the body's owner, then the lowest slots of `a`.
int place_in_line(const node::Replica& a, const node::Replica& b, EntityId body) {
  const PeerId owner = a.agreed().predicted_state().authority[body].holder();
  if (owner == a.self()) return 0;
  int before = 0;
  for (PeerId p = 0; p < a.config().slots; ++p) {
    if (p == a.self() || !a.seat(p).there() || (p > a.self() && p != owner)) continue;
    if (is_member(b, a.seat(p).at)) ++before;
  }
  return before;
}

/// Nobody lower is in the region.
bool is_lowest(const node::Replica& n) {
  for (PeerId p = 0; p < n.self(); ++p)
    if (n.seat(p).there()) return false;
  return true;
}

/// Where it will be one tick on, which is when what is ordered now is published.
BodyState one_tick_on(BodyState s) {
  s.position = s.position + s.velocity * kTickSeconds;
  s.angle += s.spin * kTickSeconds;
  return s;
}

}  // namespace

void Handover::work(const std::vector<Post>& posts) {
  errands_.clear();
  seen_.clear();
  declared_.clear();
  for (const Post& from : posts) {
    const auto& slots = from.peer->replica().agreed().predicted_state().residents.slots;
    for (EntityId b = 0; b < slots.size(); ++b) {
      if (!slots[b].present) continue;
      if (slots[b].bound == 0) {
        consider_binding(from, b);
      } else {
        consider_exit(from, b, posts);
        consider_entry(from, b, posts);
      }
    }
  }
  for (auto& [region, bundle] : declared_) post_in(posts, region)->peer->order(bundle);
  std::erase_if(due_, [this](const auto& d) { return !seen_.contains(d.first); });
}

bool Handover::falls_to_me(const Duty& duty, int place, Tick now) {
  seen_.insert(duty);
  Tick& since = due_.try_emplace(duty, now).first->second;
  if (now - since < place * kNextInLine) return false;
  since = now + kNextInLine;  // and if it has been in vain, not at once again
  return true;
}

void Handover::declare(const Post& at, const sync::Passage& p) {
  sync::Bundle& b = declared_[at.region];
  if (b.passages.size() == sync::kMaxPassages) return;  // next time
  b.passages.push_back(p);
  if (p.kind == sync::Passage::Kind::kIn) ++entries_;
  if (p.kind == sync::Passage::Kind::kOut) ++exits_;
}

// First the old region agrees where it goes: two who see it on different sides of a corner must not bring it into two.
void Handover::consider_binding(const Post& from, EntityId b) {
  const node::Replica& replica = from.peer->replica();
  const Vec2 at = replica.live().world().position(b);
  if (outside(plane_, from.region, at) < plane_.body_past) return;
  const sync::Resident& who = replica.agreed().predicted_state().residents.slots[b];
  sync::Passage p;
  p.name = who.name;
  p.crossings = who.crossings + 1;
  p.to = id_of(region_at(plane_, at));
  const PeerId owner = replica.agreed().predicted_state().authority[b].holder();
  const bool mine = owner == replica.self() || (owner == kNoPeer && is_lowest(replica));
  if (falls_to_me({p.name, {p.kind, p.crossings}}, mine ? 0 : 1 + replica.self(), replica.now())) declare(from, p);
}

void Handover::consider_entry(const Post& from, EntityId b, const std::vector<Post>& posts) {
  const node::Replica& replica = from.peer->replica();
  const sync::Resident& who = replica.agreed().predicted_state().residents.slots[b];
  const auto sure = replica.agreed().confirmed().residents.find(who.name);
  if (!sure || replica.agreed().confirmed().residents.slots[*sure] != who) return;
  const Region to = region_of(who.bound);
  const Post* there = post_in(posts, to);
  if (is_lowest(replica)) errands_.insert({from.region, to});
  if (there == nullptr) return;
  const node::Replica& other = there->peer->replica();
  sync::Passage p;
  p.kind = sync::Passage::Kind::kIn;
  p.name = who.name;
  p.crossings = who.crossings + 1;
  p.build = replica.agreed().predicted().world().scene().region->builds[b];
  p.state = one_tick_on(replica.live().world().state(b));
  if (other.config().technique.precision == Precision::kRounded) p.state = rounded(p.state);
  p.owned = replica.agreed().predicted_state().authority[b].holder() == replica.self();
  // Nobody would take the update, nor any after it.
  if (!sync::believable(p.state, other.agreed().predicted().world().scene())) return;
  const auto& known = other.agreed().predicted_state().residents;
  if (!known.slot_for(p, *other.agreed().predicted().world().scene().region)) return;
  errands_.insert({from.region, to});
  if (falls_to_me({p.name, {p.kind, p.crossings}}, place_in_line(replica, other, b), replica.now())) declare(*there, p);
}

void Handover::consider_exit(const Post& from, EntityId b, const std::vector<Post>& posts) {
  const node::Replica& replica = from.peer->replica();
  const sync::Resident& who = replica.agreed().predicted_state().residents.slots[b];
  const Post* there = post_in(posts, region_of(who.bound));
  if (there == nullptr) return;
  const node::Replica& other = there->peer->replica();
  if (other.agreed().predicted_state().residents.newest(who.name) <= who.crossings) return;
  errands_.insert({from.region, there->region});
  sync::Passage p;
  p.kind = sync::Passage::Kind::kOut;
  p.name = who.name;
  p.crossings = other.agreed().confirmed().residents.newest(who.name);
  if (p.crossings <= who.crossings) return;
  if (falls_to_me({p.name, {p.kind, p.crossings}}, place_in_line(replica, other, b), replica.now())) declare(from, p);
}

}  // namespace padr::crowd
