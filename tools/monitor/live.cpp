#include "tools/monitor/live.h"

#include <algorithm>
#include <deque>

#include "common/model/hash.h"
#include "tools/monitor/prometheus.h"

namespace padr::monitor {
namespace {

constexpr Micros kSampleEvery = kMicrosPerSecond / 4;
constexpr Micros kPeersEvery = kMicrosPerSecond / 2;
constexpr Micros kSweepEvery = kMicrosPerSecond / 4;
constexpr std::size_t kFirstEvents = 500;  // of frequent kinds, and of the others

std::vector<SessionEvent> newest(const std::deque<SessionEvent>& events, std::size_t n) {
  return {events.end() - static_cast<std::ptrdiff_t>(std::min(n, events.size())), events.end()};
}

}  // namespace

Live::Live(const Options& options, std::string source, std::uint64_t issuer, OrderDesk::Sender send,
           std::function<void(const std::string&)> note)
    : PageServer(options, "live", std::move(source)), orders_(issuer, std::move(send)), note_(std::move(note)) {}

void Live::receive(const Endpoint& from, std::span<const std::byte> datagram, Micros now) {
  set_now(now);
  sessions_.take(datagram, from, now);
  watch_session();
}

void Live::advance(Micros now) {
  set_now(now);
  if (now >= next_sweep_) {
    next_sweep_ = now + kSweepEvery;
    sessions_.advance(now);
    for (const std::string& line : sessions_.take_notes()) note_(line);
  }
  watch_session();
  release(drivers_.silent(now));
  orders_.advance(now);
  for (const OrderDesk::Outcome& o : orders_.take_outcomes())
    if (o.ticket.id || !o.ok) tell(o.ticket.viewer, answer_text(o.ticket.id, o.ok, o.text, o.ticket.about));
  ObservedSession* s = sessions_.shown();
  if (s == nullptr) return;
  pass_events();
  follow_frames();
  show(*s);
  if (now >= next_sample_) {
    next_sample_ = std::max(next_sample_ + kSampleEvery, now);
    if (s->tick() > sampled_) tell_all(series_text(s->sample(now)), true);
    sampled_ = s->tick();
  }
  const std::uint64_t seen = fingerprint();
  if (now >= next_peers_ || seen != fingerprint_) {
    next_peers_ = now + kPeersEvery;
    fingerprint_ = seen;
    tell_peers();
  }
}

/// Another session is shown than before.
void Live::watch_session() {
  ObservedSession* s = sessions_.shown();
  if (s == known_ || s == nullptr) return;
  known_ = s;
  orders_.release_all();  // those of the session that was shown before
  drivers_.clear();
  paths_.clear();
  passed_ = 0;
  sampled_ = -1;
  serial_ = 0;
  note_("shows session " + std::to_string(s->key().number) + ", scenario " + s->scenario());
  forget_shown();
  introduce_all();
}

void Live::introduce(ViewerId viewer) {
  const ObservedSession* s = sessions_.shown();
  if (s == nullptr) return;
  tell(viewer, scene_text(*s));
  tell(viewer, history_text(s->series().points()));
  tell(viewer, events_text(s->newest_events(kFirstEvents)));
  tell(viewer, peers_for(viewer));
}

void Live::pass_events() {
  const ObservedSession& s = *sessions_.shown();
  const std::uint64_t fresh = s.events_ever() - passed_;
  if (fresh == 0) return;
  passed_ = s.events_ever();
  const auto events = newest(s.events(), fresh);
  for (const SessionEvent& e : events) orders_.heard(e.process, e.event);
  tell_all(events_text(events));
}

void Live::follow_frames() {
  const ObservedSession& s = *sessions_.shown();
  if (s.serial() == serial_) return;
  serial_ = s.serial();
  for (const PeerRecord* p : s.peers())
    if (p->newest) paths_.take(p->origin.slot, *p->newest);
}

std::uint64_t Live::fingerprint() const {
  Hasher h;
  for (const PeerRecord* p : sessions_.shown()->peers()) {
    h.add(p->origin.process);
    h.add(std::uint64_t{p->origin.incarnation});
    h.add(static_cast<std::uint64_t>(p->presence(now())));
    h.add(std::uint64_t{p->paused()});
    h.add(p->hello ? p->hello->technique : "");
    h.add(drivers_.word(p->origin.slot, 0, p->newest && p->newest->driven));
  }
  return h.value();
}

std::string Live::peers_for(ViewerId viewer) {
  const ObservedSession& s = *sessions_.shown();
  return peers_text(
      s, sessions_.others(now()),
      [&](PeerId slot) {
        const PeerRecord* p = s.peer(slot);
        return drivers_.word(slot, viewer, p != nullptr && p->newest && p->newest->driven);
      },
      now());
}

void Live::tell_peers() {
  // Telling may dismiss one of them.
  const auto all = viewers();
  for (const auto& [id, viewer] : all) tell(id, peers_for(id));
}

std::vector<const PeerRecord*> Live::meant(const Command& c, std::string& why) const {
  const ObservedSession* s = sessions_.shown();
  std::vector<const PeerRecord*> out;
  if (s == nullptr) {
    why = "there is no session";
    return out;
  }
  std::string closed;
  for (const PeerRecord* p : s->peers()) {
    if (c.peer != kNoPeer && p->origin.slot != c.peer) continue;
    if (p->presence(now()) == PeerRecord::Presence::kGone) continue;
    if (!p->hello || !p->hello->control) {
      closed = "peer " + std::to_string(p->origin.slot) + " takes no orders (it was started without --control)";
      continue;
    }
    out.push_back(p);
  }
  // Of all, those who will; of one, that one.
  if (out.empty()) why = closed.empty() ? "there is no such peer" : closed;
  if (const auto* push = std::get_if<Push>(&c.what); push != nullptr && push->body >= s->scene().bodies.size()) {
    why = "body: there is none of that number";
    out.clear();
  }
  return out;
}

void Live::act(ViewerId viewer, const Asked& asked) {
  const auto* command = std::get_if<Command>(&*asked.request);
  if (command == nullptr) return answer(viewer, asked, false, "this is for recordings");
  std::string why;
  const auto peers = meant(*command, why);
  if (peers.empty()) return answer(viewer, asked, false, why);
  if (const auto* d = std::get_if<Drive>(&command->what)) return drive(viewer, asked, command->peer, *d);
  // Who holds a body, or has just won it, is the only one that may push it.
  const auto whom = std::holds_alternative<Push>(command->what) ? OrderDesk::Whom::kOne : OrderDesk::Whom::kAll;
  if (!orders_.give(peers, command->what, {viewer, asked.id, asked.about, asked.doubt}, whom))
    answer(viewer, asked, false, "too much to do already");
}

void Live::drive(ViewerId viewer, const Asked& asked, PeerId slot, const Drive& drive) {
  if (sessions_.shown()->peer(slot)->hello->input == "none")
    return answer(viewer, asked, false, "peer " + std::to_string(slot) + " is a spectator and has no avatar");
  if (drive.kind == Drive::Kind::kRelease) {
    if (!drivers_.release(slot, viewer)) return answer(viewer, asked, false, "you do not drive it");
    release({slot});
  } else {
    const ViewerId before = drivers_.take(slot, viewer, now());
    if (before != 0) tell(before, taken_text(slot));
    orders_.drive(*sessions_.shown()->peer(slot), drive);
    orders_.advance(now());
  }
  answer(viewer, asked, true, "");
}

void Live::release(const std::vector<PeerId>& slots) {
  ObservedSession* s = sessions_.shown();
  for (const PeerId slot : slots) {
    const PeerRecord* p = s == nullptr ? nullptr : s->peer(slot);
    if (p != nullptr) orders_.drive(*p, {});
  }
}

void Live::gone(ViewerId viewer) {
  release(drivers_.gone(viewer));
}

std::string Live::session_json() {
  ObservedSession* s = sessions_.shown();
  const std::string hello = greeting({});
  if (s == nullptr) return session_text(hello, "", "", "");
  const auto& points = s->series().points();
  return session_text(hello, scene_text(*s), peers_for(0), points.empty() ? "" : series_text(points.back()));
}

std::string Live::metrics() {
  return metrics_text(sessions_.shown(), sessions_.stats(), web_stats(), now());
}

}  // namespace padr::monitor
