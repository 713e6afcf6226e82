#include "common/sync/update_log.h"

#include <algorithm>
#include <cassert>
#include <iterator>
#include <limits>

namespace padr::sync {
namespace {

// A sender that is far ahead of what arrives is heard again and again; only its newest promises matter.
constexpr std::size_t kMaxWaitingMarks = 64;
constexpr Tick kForever = std::numeric_limits<Tick>::max();

}  // namespace

UpdateLog::UpdateLog(int slots) : peers_(static_cast<std::size_t>(slots)) {
  for (Peer& p : peers_) p.complete = kForever;
}

void UpdateLog::begin(PeerId peer, std::uint32_t first, Tick complete) {
  peers_[peer] = {};
  peers_[peer].have = first;
  peers_[peer].complete = complete;
  peers_[peer].end = complete == kForever ? first : kOpen;
}

void UpdateLog::Peer::arrives(std::uint32_t index) {
  if (index != have) {
    beyond.insert(std::lower_bound(beyond.begin(), beyond.end(), index), index);
    return;
  }
  ++have;
  auto filled = beyond.begin();
  for (; filled != beyond.end() && *filled == have; ++filled) ++have;
  beyond.erase(beyond.begin(), filled);
}

// By halves, as bundles are.
void UpdateLog::make_ticks() {
  constexpr std::size_t kLeast = 16;
  constexpr std::size_t kOfTheSameTick = 8;
  const std::size_t more = std::max(kLeast, ticks_made_ / 2);
  ticks_made_ += more;
  spare_ticks_.reserve(ticks_made_);
  for (std::size_t i = 0; i < more; ++i) {
    ByTick one;
    one[0].reserve(std::min(peers_.size(), kOfTheSameTick));
    spare_ticks_.push_back(one.extract(one.begin()));
  }
}

std::vector<Bundle>& UpdateLog::list_of(Tick tick) {
  const auto found = by_tick_.find(tick);
  if (found != by_tick_.end()) return found->second;
  if (spare_ticks_.empty()) make_ticks();
  ByTick::node_type replica = std::move(spare_ticks_.back());
  spare_ticks_.pop_back();
  replica.key() = tick;
  return by_tick_.insert(std::move(replica)).position->second;
}

bool UpdateLog::insert(const Bundle& bundle) {
  Peer& p = peers_[bundle.peer];
  if (bundle.index < p.have || bundle.index >= p.end || p.is_beyond(bundle.index) ||
      bundle.index - p.have > kMostBeyond)
    return false;
  if (bundle.tick < final_) {  // its peer had promised that there was none: too late to count, but nothing waits for it
    p.arrives(bundle.index);
    settle(p);
    return false;
  }
  std::vector<Bundle>& same_tick = list_of(bundle.tick);
  for (const Bundle& b : same_tick)
    if (b.peer == bundle.peer) return false;  // one a tick: two would be folded in order of arrival
  p.arrives(bundle.index);
  const auto place =
      std::find_if(same_tick.begin(), same_tick.end(), [&bundle](const Bundle& b) { return b.peer > bundle.peer; });
  same_tick.insert(place, pool_.copy(bundle));
  settle(p);
  return true;
}

bool UpdateLog::contradicts(PeerId peer, Tick tick, std::uint32_t count) const {
  const Peer& p = peers_[peer];
  if (p.beyond.empty() || p.beyond.back() < count) return false;
  for (auto it = by_tick_.begin(); it != by_tick_.end() && it->first <= tick; ++it)
    for (const Bundle& b : it->second)
      if (b.peer == peer && b.index >= count && b.index > p.have) return true;
  return false;
}

void UpdateLog::mark(PeerId peer, Tick tick, std::uint32_t count) {
  Peer& p = peers_[peer];
  if (tick <= p.complete) return;
  if (p.waiting.size() == kMaxWaitingMarks) p.waiting.erase(p.waiting.begin());
  p.waiting.push_back({tick, count});
  settle(p);
}

std::vector<Bundle> UpdateLog::take_out(PeerId peer, std::uint32_t from) {
  Peer& p = peers_[peer];
  if (p.have <= from && (p.beyond.empty() || p.beyond.back() < from)) {
    assert(of(peer, from).empty());
    return {};
  }
  p.beyond.erase(std::lower_bound(p.beyond.begin(), p.beyond.end(), from), p.beyond.end());
  std::vector<Bundle> out;
  for (auto& [tick, bundles] : by_tick_) {
    const auto beyond = [&](const Bundle& b) { return b.peer == peer && b.index >= from; };
    std::copy_if(bundles.begin(), bundles.end(), std::back_inserter(out), beyond);
    std::erase_if(bundles, beyond);
  }
  return out;
}

Tick UpdateLog::close(PeerId peer, std::uint32_t count) {
  Peer& p = peers_[peer];
  p.end = count;
  if (p.complete == kForever) p.have = std::max(p.have, count);
  std::erase_if(p.waiting, [count](const Mark& m) { return m.count > count; });
  const std::vector<Bundle> forgotten = take_out(peer, count);
  mark(peer, kForever, count);
  return forgotten.empty() ? kForever : forgotten.front().tick;
}

std::vector<Bundle> UpdateLog::hold(PeerId peer) {
  return take_out(peer, peers_[peer].have);
}

void UpdateLog::open(PeerId peer, Tick since) {
  Peer& p = peers_[peer];
  for (Mark& m : p.waiting) m.tick = std::min(m.tick, since);
  p.complete = std::min(p.complete, since);
  p.end = kOpen;
}

void UpdateLog::settle(Peer& p) {
  for (const Mark& m : p.waiting)
    if (m.count <= p.have) p.complete = std::max(p.complete, m.tick);
  std::erase_if(p.waiting, [&p](const Mark& m) { return m.count <= p.have || m.tick <= p.complete; });
}

const std::vector<Bundle>& UpdateLog::at(Tick tick) const {
  static const std::vector<Bundle> kNone;
  const auto found = by_tick_.find(tick);
  return found == by_tick_.end() ? kNone : found->second;
}

const Bundle* UpdateLog::find_at(PeerId peer, Tick tick) const {
  const std::vector<Bundle>& all = at(tick);
  const auto found = std::find_if(all.begin(), all.end(), [peer](const Bundle& b) { return b.peer == peer; });
  return found == all.end() ? nullptr : &*found;
}

const Bundle* UpdateLog::find(PeerId peer, std::uint32_t index) const {
  for (const auto& [tick, bundles] : by_tick_)
    for (const Bundle& b : bundles)
      if (b.peer == peer && b.index == index) return &b;
  return nullptr;
}

const Bundle* UpdateLog::find_out_of_order(PeerId peer, std::uint32_t index, Tick tick) const {
  for (const auto& [at, bundles] : by_tick_)
    for (const Bundle& b : bundles)
      if (b.peer == peer && (b.index > index ? at <= tick : b.index < index && at >= tick)) return &b;
  return nullptr;
}

Tick UpdateLog::complete(PeerId peer) const {
  return peers_[peer].complete;
}

std::uint32_t UpdateLog::have_beyond(PeerId peer) const {
  const Peer& p = peers_[peer];
  std::uint32_t mask = 0;
  for (const std::uint32_t index : p.beyond)
    if (index - p.have - 1 < 32) mask |= 1U << (index - p.have - 1);
  return mask;
}

std::vector<Bundle> UpdateLog::of(PeerId peer, std::uint32_t from) const {
  std::vector<Bundle> found;
  for (const auto& [tick, bundles] : by_tick_)
    for (const Bundle& b : bundles)
      if (b.peer == peer && b.index >= from) found.push_back(b);
  return found;
}

std::vector<Bundle> UpdateLog::since(Tick tick) const {
  std::vector<Bundle> found;
  for (auto it = by_tick_.lower_bound(tick); it != by_tick_.end(); ++it)
    found.insert(found.end(), it->second.begin(), it->second.end());
  return found;
}

void UpdateLog::prune(Tick final, Tick keep) {
  final_ = std::max(final_, final);
  while (!by_tick_.empty() && by_tick_.begin()->first < std::min(final, keep)) {
    ByTick::node_type replica = by_tick_.extract(by_tick_.begin());
    for (Bundle& b : replica.mapped()) pool_.give_back(std::move(b));
    replica.mapped().clear();
    spare_ticks_.push_back(std::move(replica));
  }
}

}  // namespace padr::sync
