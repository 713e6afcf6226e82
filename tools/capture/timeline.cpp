#include "tools/capture/timeline.h"

#include <algorithm>
#include <tuple>

#include "common/wire/codec.h"

namespace padr::capture {

constexpr std::size_t kMostJoins = 4096;

const char* const kEventsHelp =
    "  join, welcome, refuse           before a peer is in; refuse has the reason\n"
    "  heard                           the first state datagram of a peer\n"
    "  admission, leave, removal       peers come and go; `other` is the peer that comes or is removed\n"
    "  spectates                       a founder puts its avatar away, and stays as a spectator\n"
    "  contact_begin, contact_end      the peer's avatar touches or leaves a body (`entity`; empty: told of the "
    "avatar)\n"
    "  proxy                           a body joins or leaves the chain that the avatar moves\n"
    "  claim, release                  authority over a body; `other` is the last owner\n"
    "  claim_lost                      an update by a peer whose claim loses against the one seen before; for earlier\n"
    "                                  ticks its claim may hold\n"
    "  resend                          an update that the link to `other` has carried before, duplicates aside\n"
    "  gap                             datagram numbers skipped so far on the link to `other`; some may come later";

void Timeline::take(const Datagram& d) {
  wire::SealError error = wire::SealError::kNone;
  const auto o = d.cut ? std::nullopt : wire::open(d.payload, error);
  if (!o) return;
  const std::uint16_t session = o->header.session;
  if (o->header.kind == wire::Kind::kState) {
    const auto p = wire::decode_state(o->payload, o->header.sender);
    if (p && o->header.sender < kMaxPeers) state(d, session, *p, o->header.sender);
  } else if (o->header.kind == wire::Kind::kSession) {
    const auto m = wire::decode_session(o->payload);
    Event e;
    e.time_ns = d.time_ns;
    e.by.slot = o->header.sender;
    if (m) message(e, session, *m);
  }
}

void Timeline::message(Event e, std::uint16_t session, const wire::SessionMessage& m) {
  if (const auto* join = std::get_if<wire::Join>(&m)) {
    e.what = "join";
    e.detail = join->scenario;
    if (joins_.size() < kMostJoins || joins_.contains(join->nonce)) joins_[join->nonce].push_back(std::move(e));
    return;
  } else if (const auto* welcome = std::get_if<wire::Welcome>(&m)) {
    e.what = "welcome";
    e.other = welcome->peer;
    session_of_[welcome->nonce] = session;
  } else if (const auto* refuse = std::get_if<wire::Refuse>(&m)) {
    e.what = "refuse";
    e.detail = refuse->reason;
    session_of_.try_emplace(refuse->nonce, session);
  } else {
    return;
  }
  events_[session].push_back(std::move(e));
}

void Timeline::state(const Datagram& d, std::uint16_t session, const sync::StatePacket& p, PeerId sender) {
  Event e;
  e.time_ns = d.time_ns;
  e.tick = p.mark_tick;
  e.by = {sender, p.incarnation};
  who_[{d.from, p.incarnation}] = sender;
  std::vector<Event>& all = events_[session];
  if (heard_.emplace(session, e.by).second) {
    all.push_back(e);
    all.back().what = "heard";
  }
  const auto to = who_.find({d.to, p.to_incarnation});
  e.other = to == who_.end() ? -1 : to->second;
  const LinkId link{session, e.by, d.to, p.to_incarnation};
  if (d.second_hop) return;
  NumberWindow& seqs = seqs_[link];
  const std::uint32_t highest = seqs.highest();
  if (highest > 0 && p.seq > highest + 1) {
    all.push_back(e);
    all.back().what = "gap";
    all.back().detail = std::to_string(p.seq - highest - 1);
  }
  const bool again = seqs.add(p.seq) == NumberWindow::Seen::kAgain;
  std::set<std::uint32_t>& carried = sent_[link];
  for (const sync::Bundle& b : p.updates) {
    if (!carried.insert(b.index).second && !again) {
      all.push_back(e);
      all.back().what = "resend";
      all.back().detail = "update " + std::to_string(b.index);
    }
    if (!told_.emplace(session, e.by, b.index).second) continue;
    Told& told = updates_[session].emplace_back(Told{e, b});
    told.first.tick = b.tick;
    told.first.other = -1;
  }
}

namespace {

/// Folds the updates of one session, tick by tick, into what happened.
class Fold {
 public:
  explicit Fold(std::vector<Event>& events) : events_(events) {}

  void update(Event e, const sync::Bundle& b) {
    if (b.leave) {
      say(e, "leave");
      let_go(e, e.by.slot);
    }
    if (b.spectates) say(e, "spectates");
    if (b.admission)
      say(e, "admission", b.admission->slot,
          "incarnation " + std::to_string(b.admission->incarnation) + (b.admission->spectator ? ", a spectator" : ""));
    for (const sync::Removal& r : b.removals) {
      say(e, "removal", r.slot,
          "incarnation " + std::to_string(r.incarnation) + " from update " + std::to_string(r.count));
      let_go(e, r.slot);
    }
    if (b.avatar && is_contact(b.avatar->cause)) say(e, sync::kCauseNames[static_cast<std::size_t>(b.avatar->cause)]);
    for (const sync::BodyUpdate& u : b.bodies) {
      e.entity = u.body;
      body(e, u);
    }
  }

 private:
  static bool is_contact(sync::Cause c) { return c == sync::Cause::kContactBegin || c == sync::Cause::kContactEnd; }

  void say(const Event& e, std::string_view what, int other = -1, std::string detail = "") {
    events_.push_back(e);
    events_.back().what = what;
    events_.back().other = other;
    events_.back().detail = std::move(detail);
  }

  /// What the owner had is nobody's.
  void let_go(Event e, PeerId owner) {
    for (auto& [entity, record] : authority_) {
      if (record.holder() != owner) continue;
      record.released = true;
      e.entity = entity;
      say(e, "release", owner);
    }
  }

  void body(const Event& e, const sync::BodyUpdate& u) {
    if (is_contact(u.cause) || u.cause == sync::Cause::kProxy)
      say(e, sync::kCauseNames[static_cast<std::size_t>(u.cause)]);
    sync::Authority& record = authority_[u.body];
    const int before = record.holder() == kNoPeer ? -1 : record.holder();
    if (!u.has_state) {
      if (!u.release || record.owner != e.by.slot || record.released) return;
      record.released = true;
      return say(e, "release");
    }
    const sync::Authority claim{e.by.slot, u.release, u.epoch, u.claimed};
    if (!sync::wins(claim, record, u.body))
      return say(e, "claim_lost", record.owner, "epoch " + std::to_string(u.epoch));
    if (claim.epoch != record.epoch || claim.owner != record.owner)
      say(e, "claim", before, "epoch " + std::to_string(u.epoch));
    if (u.release && !(record.released && record.epoch == claim.epoch)) say(e, "release");
    record = claim;
  }

  std::vector<Event>& events_;
  std::map<EntityId, sync::Authority> authority_;
};

}  // namespace

std::map<std::uint16_t, std::vector<Event>> Timeline::events() const {
  auto all = events_;
  for (const auto& [nonce, joins] : joins_) {
    const auto answer = session_of_.find(nonce);
    std::vector<Event>& events = all[answer == session_of_.end() ? 0 : answer->second];
    events.insert(events.end(), joins.begin(), joins.end());
  }
  for (auto& [session, events] : all) std::ranges::stable_sort(events, {}, &Event::time_ns);
  for (const auto& [session, updates] : updates_) {
    std::vector<const Told*> in_order;
    for (const Told& t : updates) in_order.push_back(&t);
    std::ranges::sort(in_order, {},
                      [](const Told* t) { return std::tuple(t->update.tick, t->first.by, t->update.index); });
    std::vector<Event>& events = all[session];
    Fold fold(events);
    for (const Told* t : in_order) fold.update(t->first, t->update);
    std::ranges::stable_sort(events, {}, &Event::time_ns);
  }
  return all;
}

}  // namespace padr::capture
