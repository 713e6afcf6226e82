#include "common/participant/session_founder.h"

#include <algorithm>

#include "common/membership/session_objection.h"
#include "common/model/rng.h"

namespace padr::node {
Founder::Founder(SessionState& session, Micros local) : session_(session) {
  std::uint64_t seed = session.config.seed;
  while (session_.number == 0) session_.number = static_cast<std::uint16_t>(splitmix64(seed));
  session_.self = 0;
  session_.wanted = session.config.wanted;
  session_.slots = session.config.slots;
  session_.present = 1;
  session_.phase = SessionPhase::kGathering;
  if (session.config.begins_at) begin_now(*session.config.begins_at, local);
  advance(local);
}

// The founder waits for no peer: a later peer joins a session that runs.
void Founder::begin_now(Micros session, Micros local) {
  session_.beginners.assign(1, Endpoint{});
  Rng rng(session_.config.seed);
  session_.incarnation = 1 + rng.below(sync::kMostFounding);
  session_.clock.set(session - local);
  tick0_ = local - session;
  session_.phase = SessionPhase::kStarted;
}

Founder::Guest* Founder::guest_at(const Endpoint& where) {
  const auto it = std::find_if(guests_.begin(), guests_.end(), [&](const Guest& g) { return g.at == where; });
  return it == guests_.end() ? nullptr : &*it;
}

std::string Founder::objection(const wire::Join& join) const {
  std::string why = node::objection(session_.config, join);
  if (!why.empty() || session_.phase != SessionPhase::kStarted) return why;
  return "the session has already started, with " + std::to_string(session_.wanted) + " of " +
         std::to_string(session_.wanted) + " peers";
}

void Founder::refuse(const Endpoint& to, const wire::Join& join, const std::string& reason, Micros local) {
  if (!session_.may_answer(local)) return;
  session_.send(to, wire::Refuse{join.nonce, reason});
  session_.note("refused " + to_string(to) + ": " + reason, true);
}

void Founder::on_join(const Endpoint& from, const wire::Join& join, Micros local) {
  Guest* guest = guest_at(from);
  if (guest == nullptr || guest->nonce != join.nonce) {
    const std::string reason = objection(join);
    if (!reason.empty()) return refuse(from, join, reason, local);
    guest = admit(from, join, local);
    if (guest == nullptr) return;
  }
  if (session_.may_answer(local))
    session_.send(from, wire::Welcome{join.nonce, guest->peer, session_.slots, session_.wanted});
}

Founder::Guest* Founder::admit(const Endpoint& from, const wire::Join& join, Micros local) {
  // Another attempt from the same address: that program was started anew.
  std::erase_if(guests_, [&](const Guest& g) { return same_place(g.at, from); });
  PeerId free = 1;
  for (const Guest& g : guests_) {
    if (g.peer != free) break;
    ++free;
  }
  if (free >= session_.wanted) {
    // Places held by addresses that have proven nothing come free soon: the newcomer asks again.
    if (std::all_of(guests_.begin(), guests_.end(), [](const Guest& g) { return g.proven; }))
      refuse(from, join,
             "the session is full: " + std::to_string(session_.wanted) + " of " + std::to_string(session_.wanted) +
                 " peers are there",
             local);
    return nullptr;
  }
  Guest g;
  g.at = from;
  g.nonce = join.nonce;
  g.peer = free;
  g.heard = local;
  return &*guests_.insert(guests_.begin() + (free - 1), g);
}

void Founder::on_ping(const Endpoint& from, const wire::Ping& ping, Micros local) {
  Guest* guest = guest_at(from);
  if (guest == nullptr) return;
  guest->heard = local;
  if (!guest->proven) {
    guest->proven = true;
    count_present();
    session_.note("peer " + std::to_string(guest->peer) + " at " + to_string(from) + " has joined, " +
                  std::to_string(session_.present) + " of " + std::to_string(session_.wanted));
  }
  session_.send(from, wire::Pong{ping.sent, local, session_.present});
}

void Founder::on_ready(const Endpoint& from, const wire::Ready& ready, Micros local) {
  Guest* guest = guest_at(from);
  if (guest == nullptr || !guest->proven) return;
  guest->heard = local;
  guest->ready = true;
  guest->round_trip = ready.round_trip;
  guest->started = guest->started || (ready.started && session_.phase == SessionPhase::kStarted);
}

void Founder::on_bye(const Endpoint& from, const wire::Bye& bye) {
  const Guest* guest = guest_at(from);
  if (guest == nullptr || session_.phase != SessionPhase::kGathering) return;
  session_.note(
      "peer " + std::to_string(guest->peer) + " at " + to_string(from) + " has left before the start: " + bye.reason,
      true);
  std::erase_if(guests_, [&](const Guest& g) { return g.at == from; });
  count_present();
}

void Founder::count_present() {
  session_.present =
      1 + static_cast<int>(std::count_if(guests_.begin(), guests_.end(), [](const Guest& g) { return g.proven; }));
}

void Founder::advance(Micros local) {
  if (session_.phase == SessionPhase::kStarted) return repeat_start(local);
  if (session_.phase != SessionPhase::kGathering) return;
  dismiss_silent(local);
  if (all_ready()) return start(local);
  if (session_.config.patience == 0 || local - session_.born < session_.config.patience) return;
  const std::string who = std::to_string(session_.present) + " of " + std::to_string(session_.wanted) + " peers";
  const std::string reason =
      "only " + who + " came within " + std::to_string(session_.config.patience / kMicrosPerSecond) + " s";
  leave(reason);
  session_.fail(reason);
}

void Founder::dismiss_silent(Micros local) {
  const auto silent = [local](const Guest& g) {
    return local - g.heard > (g.proven ? SessionPace::kSilence : SessionPace::kUnproven);
  };
  for (const Guest& g : guests_) {
    if (silent(g) && g.proven)
      session_.note("peer " + std::to_string(g.peer) + " at " + to_string(g.at) + " went silent before the start",
                    true);
  }
  std::erase_if(guests_, silent);
  count_present();
}

bool Founder::all_ready() const {
  return static_cast<int>(guests_.size()) + 1 == session_.wanted &&
         std::all_of(guests_.begin(), guests_.end(), [](const Guest& g) { return g.proven && g.ready; });
}

void Founder::start(Micros local) {
  Micros farthest = 0;
  session_.beginners.assign(1, Endpoint{});
  for (const Guest& g : guests_) {
    session_.beginners.push_back(g.at);
    farthest = std::max(farthest, g.round_trip);
  }
  const Micros lead = SessionPace::kStartLead + SessionPace::kStartLeadTrips * farthest;
  tick0_ = local + (guests_.empty() ? 0 : std::min(lead, SessionPace::kMostStartLead));
  session_.clock.set(-tick0_);
  session_.phase = SessionPhase::kStarted;
  repeat_start(local);
}

void Founder::repeat_start(Micros local) {
  // Someone who has not answered for this long after tick 0 is the replica's case.
  if (local - tick0_ > 2 * SessionPace::kSilence) return;
  const Micros pace = local < tick0_ ? SessionPace::kStart : SessionPace::kLateStart;
  for (Guest& g : guests_) {
    if (g.started || (g.start_sent != 0 && local - g.start_sent < pace)) continue;
    g.start_sent = local;
    send_start(g.at);
  }
}

void Founder::send_start(const Endpoint& to) {
  for (std::size_t first = 0; first < session_.beginners.size(); first += wire::kMembersPerStart) {
    const auto from = session_.beginners.begin() + static_cast<std::ptrdiff_t>(first);
    const auto count = std::min(wire::kMembersPerStart, session_.beginners.size() - first);
    session_.send(to,
                  wire::Start{tick0_, {from, from + static_cast<std::ptrdiff_t>(count)}, static_cast<PeerId>(first)});
  }
}

void Founder::leave(const std::string& reason) {
  for (const Guest& g : guests_) session_.send(g.at, wire::Bye{reason});
}

}  // namespace padr::node
