#include "common/participant/session_joiner.h"

#include <algorithm>

#include "common/model/observed_address.h"
#include "common/model/rng.h"
#include "common/paths/introductions.h"
#include "common/session/session_objection.h"

namespace padr::node {
namespace {

constexpr int kMostRedirects = 4;
/// Joins that one of several contacts is sent in its first turn; from turn to turn twice as many, kTurns times: an
/// answer may take longer than the first turn.
constexpr int kFirstAsks = SessionPace::kJoins;
constexpr int kTurns = 2;
constexpr int kMostAsks = kFirstAsks << kTurns;
/// Time for which a newcomer goes on asking though all slots are taken: longer than until a member that has just
/// crashed is missed.
constexpr Micros kInsists = 2 * kMicrosPerSecond;
/// Interval between two events that tell why joining takes long.
constexpr Micros kTellAgain = 10 * kMicrosPerSecond;

}  // namespace

Joiner::Joiner(SessionState& session, Micros local) : session_(session), target_(*session.config.join), told_(local) {
  std::uint64_t seed = session.config.seed;
  do {
    nonce_ = splitmix64(seed);
  } while (nonce_ == 0);
  ask(local);
}

const Endpoint& Joiner::contact(std::size_t turn) const {
  const SessionConfig& c = session_.config;
  const std::size_t i = turn % (1 + c.others.size());
  return i == 0 ? *c.join : c.others[i - 1];
}

void Joiner::ask_next_if_unheard() {
  const std::size_t contacts = 1 + session_.config.others.size();
  const auto round = static_cast<int>(std::min<std::size_t>(turn_ / contacts, kTurns));
  if (contacts == 1 || redirects_ > 0 || asks_ < kFirstAsks << round) return;
  target_ = contact(++turn_);
  asks_ = 0;
}

void Joiner::ask(Micros local) {
  if (session_.config.joins && joins_ == *session_.config.joins + passed_on_) return;
  asked_ = local;
  ++asks_;
  ++joins_;
  const SessionConfig& c = session_.config;
  session_.send(target_, wire::Join{nonce_, c.scene_hash, c.fingerprint, c.authority, c.scenario, c.spectates});
}

void Joiner::on_join(const Endpoint& from, const wire::Join& join, Micros local) {
  if (join.nonce == nonce_) {
    // After a redirect to ourselves we ask again: we were the coordinator, and the members have not missed us yet.
    if (session_.phase == SessionPhase::kJoining && redirects_ == 0)
      session_.fail("the peer to join, " + to_string(target_) + ", is this peer itself");
    return;
  }
  if (session_.phase != SessionPhase::kEntering || !session_.may_answer(local)) return;  // the joiner asks again
  session_.send(from, wire::Redirect{join.nonce, target_});
}

// The address to ask may lack the peer's key: its first answer has it.
bool Joiner::is_target(const Endpoint& from) {
  if (!target_.has_key() && same_place(from, target_)) target_ = from;
  return from == target_;
}

void Joiner::on_welcome(const Endpoint& from, const wire::Header& header, const wire::Welcome& welcome) {
  if (session_.phase != SessionPhase::kJoining || !is_target(from) || welcome.nonce != nonce_ || header.session == 0)
    return;
  if (session_.config.sealed != (welcome.session != SessionId{})) return;
  session_.self = welcome.peer;
  session_.number = header.session;
  session_.id = welcome.session;
  session_.slots = welcome.slots;
  session_.wanted = welcome.wanted;
  session_.incarnation = welcome.incarnation;
  session_.phase = SessionPhase::kEntering;
  session_.tell({.kind = SessionEvent::Kind::kWelcomed, .peer = session_.self, .at = target_});
}

// The peer that we were redirected to may have crashed: then we ask the member that has redirected us again.
void Joiner::start_over_if_unheard(Micros local) {
  if (redirects_ == 0 || local - redirected_ < SessionPace::kUnheard) return;
  target_ = contact(turn_);
  redirects_ = 0;
  asks_ = 0;
  ask(local);
}

// The member that has redirected us will soon know another coordinator: we ask it early. Of several contacts the next
// one gets its turn.
void Joiner::on_unreachable(const Endpoint& at, Micros local) {
  if (session_.phase != SessionPhase::kJoining || at != target_) return;
  redirected_ = std::min(redirected_, local - SessionPace::kUnheard + SessionPace::kJoin);
  if (redirects_ == 0 && !session_.config.others.empty()) asks_ = std::max(asks_, kMostAsks);
  refused_ = {target_, local};
}

void Joiner::on_redirect(const Endpoint& from, const wire::Redirect& redirect, Micros local) {
  if (session_.phase != SessionPhase::kJoining || !is_target(from) || redirect.nonce != nonce_) return;
  if (++redirects_ > kMostRedirects)
    return session_.fail("too many redirects from member to member, the last by " + to_string(from));
  passed_on_ = std::min(passed_on_ + 1, kMostRedirects);
  redirected_ = local;
  target_ = as_seen_from(redirect.to, from);
  if (!introduction_ || introduction_->to != target_ || introduction_->by != from)
    introduction_ = {target_, from, local + SessionPace::kDirectly};
  session_.tell({.kind = SessionEvent::Kind::kPassedOn, .at = from, .to = target_});
  asks_ = 0;
  ask(local);
}

// A player that starts anew after a crash may find its own slot taken.
void Joiner::on_refuse(const Endpoint& from, const wire::Refuse& refuse, Micros local) {
  if (session_.phase != SessionPhase::kJoining || !is_target(from) || refuse.nonce != nonce_) return;
  const std::string why = "refused by " + to_string(from) + ": " + refuse.reason;
  if (session_.config.returns || !refuse.reason.starts_with(kFull)) return session_.fail(why);
  if (full_.empty()) full_since_ = local;
  full_ = why;
  if (local - full_since_ >= kInsists) session_.fail(why);
}

void Joiner::on_other_version(const Endpoint& from, int version) {
  if (session_.phase != SessionPhase::kJoining || !is_target(from)) return;
  session_.fail("protocol version differs: " + std::to_string(version) + " at " + to_string(from) + ", " +
                std::to_string(wire::kProtocolVersion) + " here");
}

void Joiner::advance(Micros local) {
  give_up_if_late(local);
  if (session_.phase == SessionPhase::kFailed) return;
  tell_why_it_takes_long(local);
  start_over_if_unheard(local);
  if (local - asked_ < (asks_ <= SessionPace::kJoins ? SessionPace::kJoin : SessionPace::kRareJoin)) return;
  ask_next_if_unheard();
  ask(local);
}

std::optional<Joiner::Introduction> Joiner::introduction(Micros local) const {
  const bool lasts = introduction_ && local >= introduction_->from && local - redirected_ < Introductions::kLease;
  return lasts ? introduction_ : std::nullopt;
}

void Joiner::give_up_if_late(Micros local) {
  const Micros patience = session_.config.patience;
  if (patience == 0 || local - session_.born < patience) return;
  session_.fail(why_not_in(patience, local));
}

void Joiner::tell_why_it_takes_long(Micros local) {
  if (local - told_ < kTellAgain) return;
  told_ = local;
  session_.tell({.kind = SessionEvent::Kind::kStillOut,
                 .text = why_not_in((local - session_.born) / kTellAgain * kTellAgain, local)});
}

std::string Joiner::why_not_in(Micros after, Micros local) const {
  if (!full_.empty()) return full_;
  if (session_.config.waited > 0) return no_admission(target_, session_.config.waited + after, session_.config.failed);
  std::string whom = to_string(target_);
  for (std::size_t i = 0; i < session_.config.others.size(); ++i) whom += " or " + to_string(contact(turn_ + 1 + i));
  const bool refused = refused_ && refused_->at == target_ && local - refused_->when <= 2 * SessionPace::kRareJoin;
  return "no answer from " + whom + " within " + in_seconds(after) +
         (refused                   ? ": nobody listens there"
          : session_.config.returns ? ""
          : session_.config.sealed
              ? "; it may have another session key, or none, nobody may listen there, or large datagrams get lost"
              : "; it may have a session key, or play in a crowd, nobody may listen there, or large datagrams get "
                "lost");
}

}  // namespace padr::node
