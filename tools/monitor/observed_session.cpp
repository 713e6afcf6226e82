#include "tools/monitor/observed_session.h"

#include <algorithm>
#include <limits>

namespace padr::monitor {
namespace {

/// The latest ticks of which some peers have sent frames and others may still do so.
constexpr std::size_t kRecentTicks = 6;
/// An inconsistency is repeated so long while nothing newer is confirmed.
constexpr Tick kHeldFor = 2 * kTicksPerSecond;
constexpr Vec2 kNowhere{std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::quiet_NaN()};

}  // namespace

bool is_frequent(EventKind kind) {
  switch (kind) {
    case EventKind::kContactBegin:
    case EventKind::kContactEnd:
    case EventKind::kAuthority:
    case EventKind::kRelease:
    case EventKind::kDrive:
    case EventKind::kDriveEnd:
      return true;
    default:
      return false;
  }
}

ObservedSession::ObservedSession(SessionKey key, Scene scene, std::string scenario, std::uint64_t seed, int slots,
                                 Micros now)
    : key_(key),
      scene_(std::move(scene)),
      scenario_(std::move(scenario)),
      seed_(seed),
      slots_(slots),
      entities_(scene_.bodies.size() + static_cast<std::size_t>(slots)),
      began_(now),
      gauge_(static_cast<int>(scene_.bodies.size())) {}

void ObservedSession::take(const Told& told, const Endpoint& from, Micros now) {
  PeerRecord* p = record_of(told.from, now);
  if (p == nullptr) return;
  p->heard = now;
  p->from = from;
  std::visit([&](const auto& message) { take(*p, message, now); }, told.message);
}

PeerRecord* ObservedSession::record_of(const Origin& origin, Micros now) {
  auto found = peers_.find(origin.process);
  if (found == peers_.end()) {
    if (peers_.size() >= kProcesses) return nullptr;
    found = peers_.emplace(origin.process, PeerRecord(origin)).first;
    found->second.first_heard = now;
  }
  PeerRecord& p = found->second;
  if (p.origin != origin) {
    if (holds_slot(p)) leave_slot(p.origin.slot);
    p.origin = origin;
    p.frame_pieces.clear();
    p.agreed_pieces.clear();
    p.newest.reset();
    p.links.clear();
    p.ended_at = -1;
  }
  if (origin.slot >= slots_) return &p;  // does not play yet
  const auto sits = sits_.find(origin.slot);
  if (sits != sits_.end() && sits->second == origin.process) return &p;
  if (sits != sits_.end()) {
    const PeerRecord& other = peers_.at(sits->second);
    const bool newer = origin.incarnation != other.origin.incarnation ? origin.incarnation > other.origin.incarnation
                                                                      : p.first_heard >= other.first_heard;
    if (!newer && other.presence(now) != PeerRecord::Presence::kGone) return &p;
    leave_slot(origin.slot);
  }
  sits_[origin.slot] = origin.process;
  return &p;
}

bool ObservedSession::holds_slot(const PeerRecord& p) const {
  const auto sits = sits_.find(p.origin.slot);
  return sits != sits_.end() && sits->second == p.origin.process;
}

bool ObservedSession::counts(const PeerRecord& p, const PeerRecord& q) const {
  const auto link = p.links.find(q.origin.slot);
  if (link == p.links.end()) return true;
  return link->second.there && link->second.incarnation == q.origin.incarnation;
}

bool ObservedSession::is_apart(const PeerRecord& p) const {
  return std::none_of(sits_.begin(), sits_.end(), [&](const auto& sits) {
    const PeerRecord& q = peers_.at(sits.second);
    return agreement_.of(sits.first) == Agreement::Verdict::kIdentical && counts(p, q) && counts(q, p);
  });
}

bool ObservedSession::error_known(const PeerRecord& p) const {
  const Agreement::Verdict verdict = agreement_.of(p.origin.slot);
  if (verdict == Agreement::Verdict::kApart || verdict == Agreement::Verdict::kDiffers) return false;
  return std::none_of(p.links.begin(), p.links.end(), [](const auto& link) {
    return link.second.there && (link.second.cut_out || link.second.cut_in);
  });
}

void ObservedSession::leave_slot(PeerId slot) {
  sits_.erase(slot);
  agreement_.forget(slot);
  gauge_.forget(slot);
  measured_.erase(slot);
  for (std::size_t w = 0; w < kWhiches; ++w) views_.erase({slot, static_cast<Which>(w)});
  for (auto& [tick, frames] : recent_) frames.erase(slot);
}

void ObservedSession::take(PeerRecord& p, const Hello& h, Micros) {
  p.hello = h;  // also the last that it says, after its end
}

void ObservedSession::take(PeerRecord& p, const Frame& piece, Micros now) {
  if (piece.total != entities_ || !holds_slot(p)) return;
  const auto whole = p.frame_pieces.add(piece);
  if (!whole) return;
  ++p.frames;
  if (p.newest && p.hello && whole->tick > p.newest->tick) {
    const std::int64_t due = frames_until(whole->tick, p.hello->rate) - frames_until(p.newest->tick, p.hello->rate);
    p.lost += static_cast<std::uint64_t>(std::max<std::int64_t>(0, due - 1));
  }
  if (whole->live.size() == entities_) gauge_.frame(p.origin.slot, whole);
  if (p.newest && whole->tick <= p.newest->tick) return;
  p.newest = whole;
  tick_ = std::max(tick_, whole->tick);
  put_frame(p);
  gather(p, now);
}

void ObservedSession::take(PeerRecord& p, const Agreed& piece, Micros) {
  if (piece.total != entities_ || !holds_slot(p)) return;
  const auto whole = p.agreed_pieces.add(piece);
  if (!whole || whole->at.size() != entities_) return;
  agreement_.note(p.origin.slot, whole->tick, whole->hash);
  gauge_.agreed(whole);
  Block head;
  head.slot = p.origin.slot;
  head.which = Which::kConfirmed;
  head.tick = whole->tick;
  head.target = kNowhere;
  const auto shown = views_.find({head.slot, head.which});
  if (shown == views_.end() || shown->second.head.tick < head.tick) put(head, nullptr, whole);
}

void ObservedSession::show_agreed(const Agreed& agreed) {
  tick_ = std::max(tick_, agreed.tick);
  Block head;
  head.which = Which::kConfirmed;
  head.tick = agreed.tick;
  head.target = kNowhere;
  put(head, nullptr, std::make_shared<Agreed>(agreed));
}

void ObservedSession::take(PeerRecord& p, const Status& s, Micros) {
  for (const LinkStatus& l : s.links) p.links[l.to] = l;
  if (p.status && s.tick < p.status->tick && s.steps < p.status->steps) return;  // an older one, late
  if (s.confirmed >= 0 && holds_slot(p)) agreement_.note(p.origin.slot, s.confirmed, s.hash);
  if (holds_slot(p) && agreement_.is_open(p.origin.slot)) agreement_.settle(p.origin.slot, is_apart(p));
  p.rates.take(s);
  const bool paused = p.paused();
  p.status = s;
  p.status->links.clear();
  if (!holds_slot(p)) return;
  tick_ = std::max(tick_, s.tick);
  // Who stands still tells no frames that would show it.
  if (p.newest && p.paused() != paused) put_frame(p);
}

void ObservedSession::take(PeerRecord& p, const Events& e, Micros now) {
  for (const Event& event : e.events) {
    if (event.number <= p.last_event) continue;
    p.last_event = event.number;
    if (event.kind == EventKind::kEnd) p.ended_at = now;
    events_.push_back({p.origin.slot, p.origin.process, event});
    ++events_ever_;
    const bool frequent = is_frequent(event.kind);
    if (++events_kept_[frequent] <= kEvents) continue;
    --events_kept_[frequent];
    events_.erase(std::find_if(events_.begin(), events_.end(), [frequent](const SessionEvent& kept) {
      return is_frequent(kept.event.kind) == frequent;
    }));
  }
}

std::vector<SessionEvent> ObservedSession::newest_events(std::size_t n) const {
  std::array<std::size_t, 2> room{n, n};
  std::vector<SessionEvent> out;
  for (auto e = events_.rbegin(); e != events_.rend(); ++e) {
    std::size_t& left = room[is_frequent(e->event.kind)];
    if (left == 0) continue;
    --left;
    out.push_back(*e);
  }
  std::reverse(out.begin(), out.end());
  return out;
}

void ObservedSession::advance(Micros now) {
  for (auto it = peers_.begin(); it != peers_.end();) {
    const PeerRecord& p = it->second;
    const bool gone = p.presence(now) == PeerRecord::Presence::kGone;
    const bool sits = holds_slot(p);
    if (gone && sits) {
      // Its places in pictures and comparisons are free at once, its line in the table only later.
      agreement_.forget(p.origin.slot);
      gauge_.forget(p.origin.slot);
      for (std::size_t w = 0; w < kWhiches; ++w) views_.erase({p.origin.slot, static_cast<Which>(w)});
    }
    if (gone && (!sits || now - p.heard > kForgetAfter)) {
      if (sits) leave_slot(p.origin.slot);
      it = peers_.erase(it);
    } else {
      ++it;
    }
  }
}

std::vector<const PeerRecord*> ObservedSession::peers() const {
  std::vector<const PeerRecord*> out;
  for (const auto& [slot, process] : sits_) out.push_back(&peers_.at(process));
  return out;
}

const PeerRecord* ObservedSession::peer(PeerId slot) const {
  const auto sits = sits_.find(slot);
  return sits == sits_.end() ? nullptr : &peers_.at(sits->second);
}

const PeerRecord* ObservedSession::process(std::uint64_t process) const {
  const auto found = peers_.find(process);
  return found == peers_.end() ? nullptr : &found->second;
}

bool ObservedSession::alive(Micros now) const {
  return std::any_of(peers_.begin(), peers_.end(),
                     [now](const auto& p) { return p.second.presence(now) != PeerRecord::Presence::kGone; });
}

void ObservedSession::put(const Block& head, std::shared_ptr<const Frame> frame, std::shared_ptr<const Agreed> agreed) {
  views_[{head.slot, head.which}] = {++serial_, head, std::move(frame), std::move(agreed), nullptr};
}

void ObservedSession::put_frame(const PeerRecord& p) {
  const Frame& f = *p.newest;
  Block head;
  head.slot = p.origin.slot;
  head.interaction = f.interaction;
  head.paused = p.paused();
  head.driven = f.driven;
  head.tick = f.tick;
  head.threshold = f.threshold;
  head.target = f.target;
  for (const auto& [which, places] : {std::pair{Which::kShown, &f.shown}, std::pair{Which::kLive, &f.live},
                                      std::pair{Which::kPredicted, &f.predicted}}) {
    if (places->size() != entities_) continue;
    head.which = which;
    put(head, p.newest, nullptr);
  }
}

/// The authority's view of a tick is made when everybody's frame of it is there, or will not come any more.
void ObservedSession::gather(const PeerRecord& p, Micros now) {
  const Tick tick = p.newest->tick;
  if (tick <= authority_at_) return;
  recent_[tick][p.origin.slot] = p.newest;
  const auto& have = recent_[tick];
  const bool all = std::all_of(sits_.begin(), sits_.end(), [&](const auto& sits) {
    const PeerRecord& other = peers_.at(sits.second);
    return have.contains(sits.first) || !other.newest || other.paused() ||
           other.presence(now) != PeerRecord::Presence::kHere;
  });
  if (all) put_authority(tick);
  while (recent_.size() > kRecentTicks) {
    const Tick oldest = recent_.begin()->first;
    put_authority(oldest);
    recent_.erase(oldest);
  }
}

void ObservedSession::put_authority(Tick tick) {
  const auto& frames = recent_[tick];
  if (tick <= authority_at_ || frames.empty()) return;
  authority_at_ = tick;
  const auto world = std::make_shared<Agreed>();
  world->tick = tick;
  world->total = static_cast<EntityId>(entities_);
  const std::size_t bodies = scene_.bodies.size();
  for (std::size_t e = 0; e < entities_; ++e) {
    const Frame* from = e < bodies ? frames.begin()->second.get() : nullptr;
    for (const auto& [slot, frame] : frames) {
      const bool own = e < bodies ? frame->flags[e].owner == slot : e - bodies == slot;
      if (!own) continue;
      from = frame.get();
      break;
    }
    const std::vector<Place>* at = from == nullptr ? nullptr : (from->live.empty() ? &from->shown : &from->live);
    const bool told = at != nullptr && at->size() == entities_;
    world->flags.push_back(told ? from->flags[e] : EntityFlags{});
    world->at.push_back(told ? (*at)[e] : Place{});
  }
  Block head;
  head.which = Which::kAuthority;
  head.tick = tick;
  head.target = kNowhere;
  put(head, nullptr, world);
}

std::string ObservedSession::encode(const Newest& n) {
  if (n.agreed) return encode_block(n.head, n.agreed->flags, n.agreed->at);
  const Frame& f = *n.frame;
  const auto& places = n.head.which == Which::kShown ? f.shown : (n.head.which == Which::kLive ? f.live : f.predicted);
  return encode_block(n.head, f.flags, places);
}

std::vector<ViewSource::View> ObservedSession::views(unsigned views, std::uint64_t since) {
  std::vector<View> out;
  for (auto& [what, newest] : views_) {
    if ((views & 1U << static_cast<unsigned>(what.second)) == 0 || newest.serial <= since) continue;
    if (!newest.bytes) newest.bytes = std::make_shared<const std::string>(encode(newest));
    out.push_back({newest.serial, newest.bytes});
  }
  return out;
}

std::optional<trace::InconsistencyPoint> ObservedSession::inconsistency(PeerId slot) const {
  const auto found = measured_.find(slot);
  const PeerRecord* const p = peer(slot);
  if (p == nullptr || found == measured_.end() || found->second.last.tick == 0 || !error_known(*p)) return std::nullopt;
  return found->second.last;
}

void ObservedSession::measured(PeerId slot, float fidelity_m, float pcc_m) {
  Deeds& d = deeds_[slot];
  ++d.n;
  d.fidelity_m += fidelity_m;
  d.pcc_m += pcc_m;
}

const SeriesPoint& ObservedSession::sample(Micros now) {
  newest_measured_ = gauge_.take();
  std::erase_if(newest_measured_,
                [this](const Gauge::Measured& m) { return peer(m.first) != nullptr && !error_known(*peer(m.first)); });
  for (const auto& [slot, point] : newest_measured_) {
    Sum& s = measured_[slot];
    ++s.n;
    s.sum.avatars_m += point.avatars_m;
    s.sum.bodies_m += point.bodies_m;
    s.sum.shown_m += point.shown_m;
    s.last = point;
  }
  SeriesPoint out;
  out.tick = tick_;
  for (const PeerRecord* p : peers()) {
    if (p->presence(now) == PeerRecord::Presence::kGone) continue;
    PeerPoint point;
    point.slot = p->origin.slot;
    if (!error_known(*p)) measured_.erase(point.slot);
    const auto found = measured_.find(point.slot);
    if (found != measured_.end() && found->second.n > 0) {
      Sum& s = found->second;
      const auto n = static_cast<float>(s.n);
      s.told = {s.last.tick, s.sum.avatars_m / n, s.sum.bodies_m / n, s.sum.shown_m / n};
      point.inconsistency = s.told;
      s.n = 0;
      s.sum = {};
    } else if (found != measured_.end() && tick_ - found->second.told.tick <= kHeldFor) {
      // Peers at rest say little, so nothing may have been confirmed since the last point.
      point.inconsistency = found->second.told;
    }
    if (const auto deeds = deeds_.find(point.slot); deeds != deeds_.end()) {
      const auto n = static_cast<float>(deeds->second.n);
      point.fidelity_m = deeds->second.fidelity_m / n;
      point.pcc_m = deeds->second.pcc_m / n;
      deeds_.erase(deeds);
    }
    if (const auto rates = p->current_rates(now)) {
      point.updates_per_s.emplace();
      std::transform(rates->updates_per_s.begin(), rates->updates_per_s.end(), point.updates_per_s->begin(),
                     [](double v) { return static_cast<float>(v); });
      point.kbit_per_s = static_cast<float>(rates->kbit_per_s);
    }
    if (const auto lag = p->lag_ms()) point.lag_ms = static_cast<float>(*lag);
    if (p->newest) point.threshold_m = p->newest->threshold;
    for (const auto& [to, link] : p->links)
      if (link.there && link.measured) point.delay_ms.emplace_back(to, link.delay_p50_ms);
    out.peers.push_back(std::move(point));
  }
  series_.add(std::move(out));
  return series_.points().back();
}

}  // namespace padr::monitor
