#include "common/replica/roster.h"

#include <utility>

namespace padr::node {

Tick Roster::unanswered(PeerId p) const {
  constexpr Tick kGivenUp = 1000 * kTicksPerSecond;
  const Seat& s = seats[p];
  return s.given_up >= 0 ? kGivenUp : now - std::max(s.answered, s.relayed);
}

Tick Roster::unacknowledged(PeerId p) const {
  const Seat& s = seats[p];
  return s.unacknowledged < 0 ? 0 : std::max(0, now - std::max({s.unacknowledged, s.excused, s.acks_forgiven}));
}

std::uint32_t Roster::newest_incarnation() const {
  std::uint32_t newest = incarnation;
  for (const Seat& s : seats) newest = std::max(newest, s.incarnation);
  return newest;
}

Endpoint Roster::place_of_sayer(const sync::Bundle& said) const {
  const Seat& s = seats[said.peer];
  if (said.peer == self && member && said.index >= s.first) return {};
  if (said.index >= s.first) return s.at;
  for (auto f = s.former.rbegin(); f != s.former.rend(); ++f)
    if (said.index >= f->first) return f->at;
  return {};
}

void Roster::note_answer(PeerId p, Tick mark) {
  Seat& s = seats[p];
  s.answer_mark = std::max(s.answer_mark, mark);
  s.answered = now;
  s.given_up = -1;
  s.given_up_for_good = false;
}

void Roster::freeze(PeerId p, bool frozen) {
  Seat& s = seats[p];
  s.frozen = frozen;
  if (frozen) {
    s.answered_frozen = s.answers_since = -1;
  } else if (s.answered_frozen > s.answer_mark) {
    note_answer(p, s.answered_frozen);
    s.heard = s.answered_frozen;
  }
}

void Roster::note_answer_of_frozen(PeerId p) {
  Seat& s = seats[p];
  if (s.answers_since < 0 || now - s.answered_frozen > kAnswerPause) s.answers_since = now;
  s.answered_frozen = now;
}

void Roster::give_up(PeerId p, bool for_good) {
  seats[p].given_up = now;
  seats[p].given_up_for_good |= for_good;
}

// Silence from before goes on counting: a machine that stands still for a moment every few seconds would never find
// anybody lost.
void Roster::excuse_tick() {
  const auto later = [this](Tick& t) {
    if (t >= 0) t = std::min(t + 1, now);
  };
  late = now;
  for (Seat& s : seats) {
    later(s.heard);
    later(s.answered);
    later(s.relayed);
    s.excused = now;
    s.given_up = -1;
    s.given_up_for_good = s.proven = false;
  }
}

void Roster::excuse_silence() {
  for (Seat& s : seats) s.heard = s.answered = s.excused = now;
}

void Roster::seat(PeerId p, std::uint32_t as_incarnation, std::uint32_t first, const Endpoint& at, Tick from) {
  Seat next;
  next.former = std::move(seats[p].former);
  if (next.former.size() == Seat::kFormer) next.former.erase(next.former.begin());
  next.former.push_back({seats[p].first, seats[p].incarnation, seats[p].at});
  next.presence = Presence::kThere;
  next.incarnation = as_incarnation;
  next.first = first;
  next.at = at;
  next.since = from;
  next.seated = next.heard = next.answered = next.excused = now;
  seats[p] = std::move(next);
}

}  // namespace padr::node
