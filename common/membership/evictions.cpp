#include "common/membership/evictions.h"

#include <algorithm>
#include <utility>

#include "common/membership/misbehaviour_policy.h"

namespace padr::node {

PeerId Evictions::first_of(const View& view, PeerSet without) const {
  const auto lives = [&](PeerId p) {
    if ((without & only(p)) != 0) return false;
    if (p == view.roster.self) return view.roster.member && !view.roster.leaving;
    return view.roster.seats[p].there() && !suspected(view, p) && !lost_.contains(p);
  };
  PeerId first = kNoPeer;
  for (PeerId p = 0; p < view.roster.slots(); ++p)
    if (lives(p) && (first == kNoPeer || view.roster.is_senior(p, first))) first = p;
  return first;
}

// A peer that was held up excuses the silence of the others for that time, so it takes a lost coordinator for alive
// longer than the next coordinator does. But it must not reply later than the rest: if the lost peer came back
// meanwhile, half of the members would have frozen it and half not, and neither half could go on without the other.
// A peer that resumes reads the waiting datagrams before it steps: the silence has then lasted until `due`.
bool Evictions::follows(PeerId from, const wire::Poll& poll, const View& view, Tick due) const {
  if (coordinator(view) == from) return true;
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    if (!view.roster.is_senior(p, from)) continue;
    if (p == view.roster.self) {
      if (view.roster.member && !view.roster.leaving) return false;
      continue;
    }
    const Seat& n = view.roster.seats[p];
    if (!n.there() || suspected(view, p) || lost_.contains(p)) continue;
    const bool asked_about = std::any_of(poll.lost.begin(), poll.lost.end(), [&](const wire::Seat& s) {
      return s.slot == p && s.incarnation == n.incarnation;
    });
    // A peer that was not held up can judge the silence itself. Of a peer that has never answered this one, as with a
    // newcomer, being held up explains nothing: a newcomer would follow anybody.
    const bool held_up = due - view.roster.now >= kHeldUp || view.roster.now - n.excused < kSilence;
    const bool excused = held_up && n.answer_mark >= 0;
    if (!asked_about || !excused || n.answer_mark > due - kHeardLately) return false;
  }
  return view.roster.seats[from].there() && !suspected(view, from) && !lost_.contains(from);
}

// A lower number has been taken back, unless the higher one was a lie: then the asker goes on with its own number.
bool Evictions::is_current(PeerId from, std::uint32_t number, Tick now) {
  Numbered& newest = numbers_[from];
  if (number < newest.number && now - newest.polled < kLease) return false;
  if (number != newest.number) forget_answers(from);
  newest = {number, now};
  return true;
}

void Evictions::on_poll(PeerId from, const wire::Poll& poll, const View& view, Tick due, bool vouched, Commands& out) {
  if (!is_current(from, poll.number, view.roster.now)) return;
  wire::Answer answer;
  answer.frozen = poll.freeze && !contests(from, poll, view) && !vouched && follows(from, poll, view, due);
  answer.tick = view.roster.now;
  answer.number = poll.number;
  for (const wire::Seat& s : poll.lost) {
    if (s.slot >= session_.slots || s.slot == session_.self || s.slot == from) continue;
    const Seat& n = view.roster.seats[s.slot];
    const bool same = n.incarnation == s.incarnation;
    if (answer.frozen) {
      if (n.reachable() && same && !n.frozen) out.freeze(s.slot, true);
      answered_[{from, s.slot}] = {s.incarnation, view.roster.now};
    }
    answer.lost.push_back({s.slot, s.incarnation, view.log.have(s.slot)});
    const Tick answered = n.frozen ? n.answered_frozen : n.answer_mark;
    const bool hears =
        n.frozen ? hears_again(s.slot, view) : answered >= 0 && !view.delays(s.slot) && !view.withholds(s.slot);
    if (!same || !hears) continue;
    const auto ago = static_cast<std::uint32_t>(std::max(0, answer.tick - answered));
    answer.lost.back().heard = std::min(ago + 1, wire::kMostHeard);
  }
  if (!answer.lost.empty()) out.send(view.roster.seats[from].at, answer);
}

void Evictions::on_answer(PeerId from, const wire::Answer& answer, const View& view, Commands& out) {
  if (answer.number != number_) return;
  unaware_.erase(from);
  PeerSet vetoed = 0;
  for (const wire::Seat& s : answer.lost) {
    const Tick heard = s.heard > 0 ? std::min(answer.tick, view.roster.now) + 1 - static_cast<Tick>(s.heard) : -1;
    const auto doubted = doubted_.find(s.slot);
    if (doubted != doubted_.end() && doubted->second.incarnation == s.incarnation) doubted->second.heard[from] = heard;
    const auto it = lost_.find(s.slot);
    if (it == lost_.end() || it->second.incarnation != s.incarnation) continue;
    if (!answer.frozen) {
      it->second.hears[from] = heard;
      if (is_vetoed(s.slot, it->second, view)) vetoed |= only(s.slot);
      continue;
    }
    it->second.hears.erase(from);
    // No log reaches further than this beyond an update that another log lacks.
    const std::uint32_t most = view.log.have(s.slot) + sync::UpdateLog::kMostBeyond;
    if (it->second.have.insert_or_assign(from, std::min(s.have, most)).second) moved_ = view.roster.now;
  }
  if (vetoed != 0) take_back(vetoed, view, out);
}

// Whether the peer has published something after it was frozen, or so shortly before that it cannot have been silent,
// and nothing before that is missing. That may take many datagrams of a busy peer.
bool Evictions::lives(PeerId p, const Lost& lost, const View& view) const {
  const LastHeard& h = lost.grounds;
  const std::uint32_t have = view.log.have(p);
  const std::uint32_t next = lost.next(have);
  if (h.given_up || ordered() || next == have) return false;
  const Tick newest = lost.fetched.at(next - 1).tick;
  const Tick alive = std::max(h.now - kHeardLately, h.refused.value_or(-1));
  return newest > alive && newest <= view.roster.now + kHeardLately;
}

// A member that says which updates it has sends those that another lacks; one that vouches for the peer, those that
// the poll says are lacking.
void Evictions::keep(PeerId from, const wire::Fetched& fetched, Lost& lost, const View& view,
                     MisbehaviourPolicy& misbehaviour) {
  const std::uint32_t have = view.log.have(fetched.slot);
  for (const sync::Bundle& b : fetched.updates) {
    const bool asked_for = b.index >= std::min(lost.least, have) && b.index <= have + sync::UpdateLog::kMostBeyond;
    // No member has filed an update from so far in the future: all would wait for that time.
    const bool in_time = b.tick <= view.roster.now + sync::AdmitLimits{}.max_ahead;
    if (!asked_for || !in_time || lost.fetched.contains(b.index) ||
        sync::admit(b, view.scene, session_.slots) != sync::DropReason::kNone || !misbehaviour.said(from, b, view))
      continue;
    lost.fetched.emplace(b.index, b);
    moved_ = view.roster.now;
  }
}

void Evictions::on_fetched(PeerId from, const wire::Fetched& fetched, const View& view,
                           MisbehaviourPolicy& misbehaviour, Commands& out) {
  const auto it = lost_.find(fetched.slot);
  if (it == lost_.end() || it->second.incarnation != fetched.incarnation) return;
  keep(from, fetched, it->second, view, misbehaviour);
  // Nobody is relayed for ever: a member that has agreed to that does not vouch for it.
  const bool for_long = view.roster.silence(fetched.slot) >= kRelayUntil && it->second.have.contains(from);
  if (for_long || !lives(fetched.slot, it->second, view)) return;
  const auto evidence = std::move(it->second.fetched);
  take_back(only(fetched.slot), view, out);
  thaw(view, out);
  for (const auto& [number, b] : evidence)
    if (number >= view.log.have(fetched.slot)) out.relay({fetched.slot, fetched.incarnation, {b}}, from);
}

// Whether a frozen peer and this one have heard each other for a while: it was silent here, too, but for a moment only.
bool Evictions::hears_again(PeerId p, const View& view) {
  const Seat& s = view.roster.seats[p];
  return s.there() && s.frozen && !s.given_up_for_good && s.answered_frozen - s.answers_since >= kHeardAgain &&
         view.roster.now - s.answered_frozen <= Roster::kAnswerPause;
}

// Whether this peer hears somebody again whom it has frozen for this asker. Then it wants the poll to be taken back.
bool Evictions::contests(PeerId from, const wire::Poll& poll, const View& view) {
  bool any = false;
  for (const wire::Seat& s : poll.lost) {
    const auto it = answered_.find({from, s.slot});
    if (it == answered_.end() || it->second.incarnation != s.incarnation) continue;
    it->second.polled = view.roster.now;
    if (lost_.contains(s.slot) || !hears_again(s.slot, view)) continue;
    if (it->second.contested < 0) it->second.contested = view.roster.now;
    any = true;
  }
  return any;
}

// Whether an asker lies. An honest one polls until it gives its order or takes the poll back, and does that as long as
// it has not given its order, if somebody hears the peer.
bool Evictions::has_expired(PeerId asker, const Answered& a, const View& view) const {
  const Tick now = view.roster.now;
  if (!session_.config.sealed) return false;
  if (a.contested >= 0 && now - a.contested >= kLease && now - a.polled < kLease) return true;
  return now - a.polled >= kLease && view.log.complete(asker) >= a.polled + kLease;
}

// An asker may evict on our reply until it takes the poll back, leaves or is removed.
void Evictions::thaw(const View& view, Commands& out) {
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    if (!view.roster.seats[p].frozen || lost_.contains(p)) continue;
    if (hears_again(p, view))
      std::erase_if(answered_, [&](const auto& entry) {
        return entry.first.second == p && has_expired(entry.first.first, entry.second, view);
      });
    const bool asked = std::any_of(answered_.begin(), answered_.end(), [&](const auto& entry) {
      return entry.first.second == p && entry.second.incarnation == view.roster.seats[p].incarnation &&
             view.roster.seats[entry.first.first].there();
    });
    if (!asked) out.freeze(p, false);
  }
}

// Whether members that do not follow the poll keep p in: they hear it again, and follow only when it is silent to them,
// too.
bool Evictions::is_vetoed(PeerId p, const Lost& lost, const View& view) const {
  LastHeard h = lost.grounds;
  h.now = view.roster.now;
  h.heard.clear();
  for (const auto& [q, heard] : lost.hears)
    if (q != p && counts(q, view) && view.roster.unanswered(q) < kDoubt) h.heard.push_back(heard);
  return stays_by_word(h);
}

// thaw() then resumes each peer that no other asker polls about. All members have to reply anew about those that are
// still lost. Who was awaited before has no more time for it: once, vetoes about one peer, again and again, kept
// everybody from being left out.
void Evictions::take_back(PeerSet who, const View& view, Commands& out) {
  if (ordered()) return;
  const Tick now = view.roster.now;
  const bool decides = coordinator(view) == session_.self;
  taken_back_.clear();
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    if ((who & only(p)) == 0 || !lost_.contains(p)) continue;
    if (taken_back_.size() < wire::kMostLost) taken_back_.push_back({p, lost_[p].incarnation});
    if (decides) out.tell({.kind = SessionEvent::Kind::kHeardAgain, .peer = p});
    lost_.erase(p);
    for (auto& [slot, lost] : lost_) {
      Tick& asked = lost.asked.try_emplace(p, lost.grounds.now).first->second;
      asked = std::max(asked, now + kAnswerPatience - kWithheld);
    }
  }
  for (auto& [slot, lost] : lost_) {
    for (const auto& [q, have] : lost.have) lost.asked[q] = now;
    lost.have.clear();
    lost.hears.clear();
  }
  missing_.reset();
  number_ = number_ < wire::kMostPollNumber ? number_ + 1 : 1;  // the members take a lower one after kLease
  polled_ = now - kAskAgain;
  taken_back_at_ = now;
  unaware_.clear();
  for (PeerId p = 0; p < view.roster.slots(); ++p)
    if (p != session_.self && view.roster.seats[p].there()) unaware_.insert(p);
  told_ = now - kAskAgain;
}

// Whoever is heard again may be the only one through which this peer reaches the others, who then get none of its
// polls. And if this peer is no longer the coordinator, the others follow another one.
void Evictions::take_back_if_over(const View& view, Commands& out) {
  const bool decides = coordinator(view) == session_.self;
  PeerSet over = 0;
  for (const auto& [p, lost] : lost_)
    if (!decides || hears_again(p, view)) over |= only(p);
  if (over != 0) take_back(over, view, out);
}

// Any other poll with the new number has the same effect, but there may be none.
void Evictions::tell_taken_back(const View& view, Commands& out) {
  std::erase_if(unaware_, [&](PeerId p) { return !view.roster.seats[p].there(); });
  if (unaware_.empty() || view.roster.now - told_ < kAskAgain) return;
  told_ = view.roster.now;
  for (const PeerId p : unaware_) {
    wire::Poll poll{{}, false, number_};
    for (const wire::Seat& s : taken_back_)
      if (s.slot != p) poll.lost.push_back(s);
    if (!poll.lost.empty() && counts(p, view)) out.send(view.roster.seats[p].at, poll);
  }
}

// Whether this peer is the most senior one that answers: it will have to decide.
bool Evictions::is_first_well(const View& view) const {
  if (!view.roster.member || view.roster.leaving) return false;
  for (PeerId p = 0; p < view.roster.slots(); ++p)
    if (view.roster.is_senior(p, session_.self) && view.roster.seats[p].there() && view.roster.unanswered(p) < kDoubt &&
        !lost_.contains(p))
      return false;
  return true;
}

void Evictions::doubt(const View& view, Commands& out) {
  const bool first = is_first_well(view);
  wire::Poll question{{}, false, number_};
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    const Seat& n = view.roster.seats[p];
    if (!first || p == session_.self || !n.there() || view.roster.unanswered(p) < kDoubt || lost_.contains(p)) {
      doubted_.erase(p);
      continue;
    }
    Doubted& d = doubted_[p];
    if (d.incarnation != n.incarnation) d = {n.incarnation, {}, false};
    if (question.lost.size() < wire::kMostLost) question.lost.push_back({p, n.incarnation});
  }
  if (question.lost.empty() || view.roster.now - doubts_asked_ < kAskAgain) return;
  doubts_asked_ = view.roster.now;
  poll(question, view, out);
}

LastHeard Evictions::hearsay(PeerId p, const View& view) const {
  const Seat& n = view.roster.seats[p];
  const bool deaf = n.given_up < 0 && view.roster.silence(p) < kTicksPerSecond;
  LastHeard h{view.roster.now, view.roster.unanswered(p), {}, n.given_up_for_good, deaf, {}, {}};
  if (n.given_up >= 0) h.refused = n.given_up;
  if (number_ > 0) h.taken_back = taken_back_at_;
  const Doubted& d = doubted_.at(p);
  for (PeerId q = 0; q < view.roster.slots(); ++q) {
    // Members of another part, which have frozen us, hear one another, but do not answer us.
    if (q == p || !counts(q, view) || view.roster.unanswered(q) >= kDoubt) continue;
    const auto said = d.heard.find(q);
    h.heard.push_back(said == d.heard.end() ? std::nullopt : std::optional(said->second));
  }
  return h;
}

// Whether p, about which the poll has just been taken back, is left alone while the others that are lost are evicted.
// One of them may have been the cause: members that have frozen p for it take nothing from p until it is out.
bool Evictions::waits_for_others(PeerId p, const View& view) const {
  return !lost_.empty() && view.roster.now - taken_back_at_ < kAnswerPatience &&
         std::any_of(taken_back_.begin(), taken_back_.end(), [&](const wire::Seat& s) {
           return s.slot == p && s.incarnation == view.roster.seats[p].incarnation;
         });
}

void Evictions::notice(const View& view, Commands& out) {
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    if (p == session_.self || !view.roster.seats[p].there() || !suspected(view, p) || lost_.contains(p)) continue;
    if (coordinator(view) != session_.self) return;
    const auto doubted = doubted_.find(p);
    if (doubted == doubted_.end() || waits_for_others(p, view) || hears_again(p, view)) continue;
    const LastHeard h = hearsay(p, view);
    if (!may_evict(h)) {
      if (is_heard(h) && !h.deaf && !std::exchange(doubted->second.told, true))
        out.tell({.kind = SessionEvent::Kind::kHeard, .peer = p});
      continue;
    }
    doubted_.erase(doubted);
    out.freeze(p, true);
    lost_[p].incarnation = view.roster.seats[p].incarnation;
    lost_[p].grounds = h;
    polled_ = view.roster.now - kAskAgain;
    moved_ = view.roster.now;
    out.tell({.kind = SessionEvent::Kind::kSuspected, .peer = p});
  }
}

/// Whether replies of p are awaited. An update that only a lost peer had will never be sent. Whoever has left confirms
/// nothing more that others have to agree with, and may only say that it has left.
bool Evictions::counts(PeerId p, const View& view) const {
  return p != session_.self && view.roster.seats[p].there() && !lost_.contains(p) && !withholds_.contains(p);
}

void Evictions::ask(const View& view, Commands& out) {
  if (view.roster.now - polled_ < kAskAgain) return;
  polled_ = view.roster.now;
  wire::Poll question{{}, true, number_};
  for (const auto& [slot, lost] : lost_)
    if (question.lost.size() < wire::kMostLost)
      question.lost.push_back({slot, lost.incarnation, lost.next(view.log.have(slot))});
  poll(question, view, out);
}

void Evictions::poll(const wire::Poll& poll, const View& view, Commands& out) {
  for (PeerId p = 0; p < view.roster.slots(); ++p)
    if (p != session_.self && view.roster.seats[p].reachable() && !lost_.contains(p))
      out.send(view.roster.seats[p].at, poll);
}

// What an asker has said meanwhile waits to be read. Once, whoever had stood still and caught up took an honest asker
// for a liar, and confirmed what the lost peer said on its return: another world than the others had.
void Evictions::excuse_askers(const View& view) {
  if (view.roster.now - view.roster.late > 1) return;
  for (auto& [who, answered] : answered_) {
    answered.polled = std::min(answered.polled + 1, view.roster.now);
    if (answered.contested >= 0) answered.contested = std::min(answered.contested + 1, view.roster.now);
  }
}

void Evictions::advance(const View& view, Commands& out) {
  excuse_askers(view);
  std::erase_if(lost_, [&](const auto& entry) { return !view.roster.seats[entry.first].frozen; });
  take_back_if_over(view, out);
  thaw(view, out);
  tell_taken_back(view, out);
  doubt(view, out);
  notice(view, out);
  if (lost_.empty()) withholds_.clear();
  go_on_without(view, out);
  missing_.reset();
  if (lost_.empty() || ordered()) return;
  ask(view, out);  // until the order is given, so that members know that it is not
  if (!all_answered(view)) return;
  for (auto& [p, lost] : lost_)
    if (!gather(p, lost, view, out)) return;
  bury(out);
}

bool Evictions::ordered() const {
  return std::any_of(lost_.begin(), lost_.end(), [](const auto& entry) { return entry.second.ordered; });
}

}  // namespace padr::node
