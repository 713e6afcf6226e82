#include "common/participant/session_joiner.h"

#include <algorithm>

#include "common/membership/session_objection.h"
#include "common/model/observed_address.h"
#include "common/model/rng.h"

namespace padr::node {
namespace {

constexpr int kMostRedirects = 4;

std::string seconds(Micros t) {
  return std::to_string(t / kMicrosPerSecond) + " s";
}

}  // namespace

Joiner::Joiner(SessionState& session, Micros local) : session_(session), target_(*session.config.join) {
  std::uint64_t seed = session.config.seed;
  do {
    nonce_ = splitmix64(seed);
  } while (nonce_ == 0);
  ask(local);
}

void Joiner::ask(Micros local) {
  asked_ = local;
  const SessionConfig& c = session_.config;
  session_.send(target_, wire::Join{nonce_, c.scene_hash, c.fingerprint, c.authority, c.scenario});
}

void Joiner::on_join(const Endpoint& from, const wire::Join& join, Micros local) {
  if (join.nonce == nonce_) {
    // Passed on to ourselves: we were the founder or coordinator, and nobody has missed us yet. Asking again will do.
    if (session_.phase == SessionPhase::kJoining && redirects_ == 0)
      session_.fail("the peer to join, " + to_string(target_) + ", is this peer itself");
    return;
  }
  if (session_.phase != SessionPhase::kGathering || !session_.may_answer(local)) return;  // it asks again
  session_.send(from, wire::Redirect{join.nonce, target_});
  session_.note("passed " + to_string(from) + " on to the founder at " + to_string(target_));
}

// We may have been told only where it is; who it is, its first answer says.
bool Joiner::is_target(const Endpoint& from) {
  if (!target_.has_key() && same_place(from, target_)) target_ = from;
  return from == target_;
}

void Joiner::on_welcome(const Endpoint& from, const wire::Header& header, const wire::Welcome& welcome, Micros local) {
  if (session_.phase != SessionPhase::kJoining || !is_target(from) || welcome.nonce != nonce_ || header.session == 0)
    return;
  session_.self = welcome.peer;
  session_.number = header.session;
  session_.slots = welcome.slots;
  session_.wanted = welcome.wanted;
  session_.incarnation = welcome.incarnation;
  heard_ = local;
  if (welcome.running) {
    session_.phase = SessionPhase::kEntering;
    session_.note("the session is running; joining as peer " + std::to_string(session_.self) + " by " +
                  to_string(target_));
    return;
  }
  session_.phase = SessionPhase::kGathering;
  session_.note("joined " + to_string(target_) + " as peer " + std::to_string(session_.self) + " of " +
                std::to_string(session_.wanted));
  ping(local);
}

// Whoever we were passed on to may have crashed just now: then ask again where we asked first.
void Joiner::start_over_if_unheard(Micros local) {
  if (redirects_ == 0 || local - redirected_ < SessionPace::kUnheard) return;
  target_ = *session_.config.join;
  redirects_ = 0;
  ask(local);
}

// Where we asked first there is somebody who will know better before long.
void Joiner::on_unreachable(const Endpoint& at, Micros local) {
  if (session_.phase != SessionPhase::kJoining || at != target_) return;
  redirected_ = std::min(redirected_, local - SessionPace::kUnheard + SessionPace::kJoin);
}

void Joiner::on_redirect(const Endpoint& from, const wire::Redirect& redirect, Micros local) {
  if (session_.phase != SessionPhase::kJoining || !is_target(from) || redirect.nonce != nonce_) return;
  if (++redirects_ > kMostRedirects)
    return session_.fail("too many redirects from member to member, the last by " + to_string(from));
  redirected_ = local;
  target_ = as_seen_from(redirect.founder, from);
  session_.note(to_string(from) + " passes us on to the founder at " + to_string(target_));
  ask(local);
}

void Joiner::on_refuse(const Endpoint& from, const wire::Refuse& refuse) {
  if (session_.phase != SessionPhase::kJoining || !is_target(from) || refuse.nonce != nonce_) return;
  session_.fail("refused by " + to_string(from) + ": " + refuse.reason);
}

void Joiner::on_other_version(const Endpoint& from, int version) {
  if (session_.phase != SessionPhase::kJoining || !is_target(from)) return;
  session_.fail("protocol version differs: " + std::to_string(version) + " at " + to_string(from) + ", " +
                std::to_string(wire::kProtocolVersion) + " here");
}

void Joiner::on_pong(const Endpoint& from, const wire::Pong& pong, Micros local) {
  // Only of our own recent pings, or the sample is nonsense.
  if (from != target_ || session_.phase < SessionPhase::kGathering) return;
  if (pong.sent > local || local - pong.sent > SessionPace::kSilence || pong.sent < session_.born) return;
  heard_ = local;
  session_.present = pong.present;
  offset_.add(pong.sent, pong.founder, local);
  // Samples go on improving the clock until it is needed; from tick 0 on it is only ever steered.
  if (session_.phase == SessionPhase::kStarted && session_.clock.now(local) < 0)
    session_.clock.set(offset_.offset() - tick0_);
}

void Joiner::on_start(const Endpoint& from, const wire::Start& start, Micros local) {
  const auto end = static_cast<int>(start.first + start.members.size());
  if (from != target_ || offset_.samples() == 0 || end > session_.wanted) return;
  heard_ = local;
  if (session_.phase == SessionPhase::kGathering) {
    if (!take_members(start)) return;
    for (const Endpoint& e : told_) session_.beginners.push_back(as_seen_from(e, from));
    session_.beginners[0] = from;
    tick0_ = start.tick0;
    session_.clock.set(offset_.offset() - tick0_);
    session_.phase = SessionPhase::kStarted;
  }
  if (session_.phase == SessionPhase::kStarted) session_.send(target_, wire::Ready{offset_.round_trip(), true});
}

bool Joiner::take_members(const wire::Start& start) {
  told_.resize(static_cast<std::size_t>(session_.wanted));
  std::copy(start.members.begin(), start.members.end(), told_.begin() + start.first);
  return std::all_of(told_.begin() + 1, told_.end(), [](const Endpoint& e) { return e.is_set(); });
}

void Joiner::on_bye(const Endpoint& from, const wire::Bye& bye) {
  if (session_.phase != SessionPhase::kGathering || from != target_) return;
  session_.fail("the founder at " + to_string(from) + " has ended the session before its start: " + bye.reason);
}

void Joiner::ping(Micros local) {
  pinged_ = local;
  session_.send(target_, wire::Ping{local});
  if (agreed() && session_.phase == SessionPhase::kGathering)
    session_.send(target_, wire::Ready{offset_.round_trip(), false});
}

void Joiner::advance(Micros local) {
  if (session_.phase == SessionPhase::kFailed || session_.phase == SessionPhase::kEntering) return;
  if (session_.phase == SessionPhase::kStarted) {
    if (session_.clock.now(local) < 0 && local - pinged_ >= SessionPace::kPing) ping(local);
    return;
  }
  give_up_if_late(local);
  if (session_.phase == SessionPhase::kJoining) start_over_if_unheard(local);
  if (session_.phase == SessionPhase::kJoining && local - asked_ >= SessionPace::kJoin) ask(local);
  if (session_.phase == SessionPhase::kGathering &&
      local - pinged_ >= (agreed() ? SessionPace::kIdlePing : SessionPace::kPing))
    ping(local);
}

void Joiner::give_up_if_late(Micros local) {
  if (session_.phase == SessionPhase::kGathering && local - heard_ > SessionPace::kSilence)
    return session_.fail("the founder at " + to_string(target_) + " has been silent for " +
                         seconds(SessionPace::kSilence));
  if (session_.config.patience == 0 || local - session_.born < session_.config.patience) return;
  const std::string within = " within " + seconds(session_.config.patience);
  if (session_.phase == SessionPhase::kJoining)
    return session_.fail("no answer from " + to_string(target_) + within +
                         (session_.config.sealed ? "; it may have another session key, or none" : ""));
  const std::string reason =
      "only " + std::to_string(session_.present) + " of " + std::to_string(session_.wanted) + " peers came" + within;
  leave(reason);
  session_.fail(reason);
}

void Joiner::leave(const std::string& reason) {
  if (session_.phase == SessionPhase::kGathering) session_.send(target_, wire::Bye{reason});
}

}  // namespace padr::node
