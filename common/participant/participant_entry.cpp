// A Participant's entry into a session: the first time, and each time that it joins anew.
#include <algorithm>
#include <utility>

#include "common/membership/signers.h"
#include "common/model/observed_address.h"
#include "common/model/rng.h"
#include "common/participant/participant.h"
#include "common/session/session_objection.h"
#include "common/wire/signature.h"
#include "common/wire/transfer_codec.h"

namespace padr::node {
namespace {

/// Limits on how far a transfer's tick is from the session's by our clock, in ticks: a transfer beyond them is not of
/// this session, or would take too long to step up from.
constexpr Tick kMostAhead = 2 * kTicksPerSecond;
constexpr Tick kMostBehind = 120 * kTicksPerSecond;
/// Most ticks that a joiner steps in one call: datagrams must get their turn.
constexpr Tick kAtOnce = kTicksPerSecond;
/// Interval between two attempts to join anew.
constexpr Micros kTryAgain = 500'000;
constexpr Micros kReturnPatience = 6 * kMicrosPerSecond;
/// Interval between two events that tell why such an attempt has failed.
constexpr Micros kTellFailure = 10 * kMicrosPerSecond;

}  // namespace

ReplicaConfig Participant::replica_config(const Session& session) const {
  ReplicaConfig c = config_.replica;
  c.self = session.self();
  c.slots = session.slots();
  c.session = session.number();
  c.session_id = session.id();
  c.incarnation = session.incarnation();
  c.wanted = session.wanted();
  c.spectates = config_.session.spectates;
  if (channels_)
    c.sign = [key = channels_->signing_key(), said = wire::Said{c.session_id, c.incarnation}](const sync::Bundle& b) {
      return wire::sign_update(key, said, b);
    };
  return c;
}

std::optional<RecordedReplica::Recording> Participant::recording() const {
  return config_.recording ? config_.recording(begun()) : std::nullopt;
}

Replica::ConfirmedSink Participant::sink() {
  if (!config_.on_confirmed) return {};
  return [this, incarnation = begun()](const sync::FoldState& s, std::uint64_t hash) {
    config_.on_confirmed(incarnation, s, hash);
  };
}

void Participant::bring_in_next(Micros local) {
  Session& s = *next_.session;
  if (!current_.session && !next_.membership && s.phase() == SessionPhase::kEntering) give_up_entering(local);
  if (s.phase() == SessionPhase::kFailed && current_.session) {
    if (s.failure().find(kFull) != std::string::npos) current_.membership->give_seat_back();
    drop_attempt(local);
    try_again_ = local + kTryAgain;
  } else if (s.lost_introducer()) {
    ask_again(local);
  } else if (!next_.replica && s.phase() == SessionPhase::kEntering &&
             std::find(had_.begin(), had_.end(), s.incarnation()) != had_.end()) {
    // Its numbers could count from anew there, and then it would sign what contradicts what it has signed before.
    s.state().fail(to_string(s.let_in_by()) + " gives this peer an incarnation that it has had");
  } else if (!next_.replica && s.phase() == SessionPhase::kMember) {
    found();
  } else if (!next_.replica && s.may_enter()) {
    if (const std::string why = no_room_for(s); !why.empty()) return s.state().fail(why);
    if (current_.membership && current_.membership->convicts(s.introducer().key))
      return s.state().fail(to_string(s.introducer()) + " has lied");
    begin_with_transfer(local);
  } else if (next_.replica && next_.replica->replica().member()) {
    s.admitted();
    take_over();
  } else if (next_.membership) {
    watch(next_, local);
  } else if (next_.replica) {
    catch_up(next_, local);
  }
}

void Participant::drop_attempt(Micros local) {
  if (!failed_ || local - *failed_ >= kTellFailure) {
    failed_ = local;
    next_.session->state().tell({.kind = SessionEvent::Kind::kStillOut, .text = next_.session->failure()});
  }
  collect(next_);
  next_ = {};
}

// Only until it has asked for its admission, which may be under way. In a crowd many may wait for their turn to come
// into a region, and have others meanwhile.
void Participant::give_up_entering(Micros local) {
  const Micros patience = scene_.region ? 0 : config_.session.patience;
  if (patience > 0 && local - began_ >= patience)
    next_.session->state().fail(no_admission(next_.session->let_in_by(), patience));
}

// The introducer of our first incarnation is lost: we ask anew, and another member will admit us.
void Participant::ask_again(Micros local) {
  SessionConfig c = config_.session;
  c.waited = local - began_;
  c.failed = next_.session->failure();
  if (c.patience > 0) c.patience -= c.waited;
  if (config_.session.patience > 0 && c.patience <= 0) return;
  drop_attempt(local);
  c.seed = derive_seed(c.seed, 0xA6A, ++tries_);
  next_.session = std::make_unique<Session>(c, local);
}

// The founder sets the number of slots: it may be mistaken, or lie.
std::string Participant::no_room_for(const Session& session) const {
  const std::size_t places = scene_.avatar.spawns.size();
  if (static_cast<std::size_t>(session.slots()) <= places) return "";
  return "the session has more avatar slots (" + std::to_string(session.slots()) +
         ") than the scenario has places to start from (" + std::to_string(places) + ")";
}

// Before its admission an incarnation steps along, so that it is up to date when it is admitted.
void Participant::watch(Incarnation& incarnation, Micros local) {
  const Micros now = incarnation.session->session_now(local);
  for (Tick i = 0; i < kAtOnce && tick_start(incarnation.replica->replica().now() + 1) <= now; ++i) {
    incarnation.replica->step({});
    incarnation.membership->advance(local);
  }
}

// Steps from the transfer's tick to the present one, and then asks to be admitted.
void Participant::catch_up(Incarnation& incarnation, Micros local) {
  if (!incarnation.replica->catch_up(kAtOnce)) return;
  incarnation.membership = std::make_unique<Membership>(incarnation.session->state(), *incarnation.replica);
  // Membership forgets the members among them itself: an address in a slot proves nothing, its peer may have gone.
  for (const sync::Transfer::Gone& g : std::exchange(incarnation.gone, {})) incarnation.membership->remember(g);
  incarnation.membership->take(std::exchange(incarnation.proofs, {}));
  incarnation.session->hand_over_to(incarnation.membership.get());
  incarnation.session->enter(local);
}

// A session begins at tick 0 with its founder in it, a region of a crowd at the tick that its crowd is at.
void Participant::found() {
  const ReplicaConfig c = replica_config(*next_.session);
  if (const auto begins_at = config_.session.begins_at) {
    const auto now = tick_at(*begins_at);
    return go_on_from(sync::founding(scene_, c.slots, c.technique.authority, now, c.incarnation), c, now);
  }
  next_.replica = std::make_unique<RecordedReplica>(scene_, c, recording(), sink());
  take_over();
}

void Participant::go_on_from(const sync::Transfer& start, const ReplicaConfig& config, Tick now) {
  next_.replica = std::make_unique<RecordedReplica>(scene_, config, start, now, recording(), sink());
  next_.replica->catch_up(0);  // it is at that tick already
  take_over();
}

// Nobody is known to be in the session any more: it goes on from the last state that this peer knows. The others that
// have left find it where they ask for somebody.
void Participant::found_anew(Micros local) {
  const Replica& before = replica();
  SessionConfig c = config_.session;
  c.join.reset();
  c.others.clear();
  c.number = session().number();
  c.id = session().id();
  c.slots = before.config().slots;
  c.wanted = std::max(1, session().wanted());
  c.begins_at = session().session_now(local);
  next_ = {};
  next_.session = std::make_unique<Session>(c, local);
  // Two that found it anew at the same time, and meet later, must not take each other for themselves.
  next_.session->state().incarnation += before.roster().newest_incarnation() + 1;
  const ReplicaConfig r = replica_config(*next_.session);
  go_on_from(before.founding_anew(r.incarnation), r, before.now());
}

void Participant::begin_with_transfer(Micros local) {
  Session& s = *next_.session;
  auto transfer = wire::decode_transfer(s.transfer(), scene_, s.slots());
  if (!transfer || transfer->slots.size() <= s.introducer_number()) {
    s.state().fail("the transfer of " + to_string(s.introducer()) + " does not decode");
    return;
  }
  if (const sync::Member& own = transfer->state.members[s.self()]; own.present && own.incarnation == s.incarnation())
    return s.state().fail("by the transfer of " + to_string(s.introducer()) + ", this peer is in already");
  const Tick now = tick_at(s.session_now(local));
  const Tick then = transfer->state.tick;
  if (then > now + kMostAhead || then < now - kMostBehind) {
    // What others showed may be out of date: a suspended machine's clock has stood still, or the session went on by
    // another time. The next attempt does without.
    most_offset_.reset();
    doubts_time_ = true;
    s.state().fail("the transfer of " + to_string(s.introducer()) + " is of tick " + std::to_string(then) +
                   ", but the session is at " + std::to_string(now));
    return;
  }
  // No confirmed tick is ahead of the session's time: the introducer has told a wrong one. Until the clock got there,
  // the live world would stand still.
  if (then > now) s.time_is_at_least(tick_start(then), local);
  transfer->by = s.introducer_number();
  transfer->slots[transfer->by].at = s.introducer();
  if (channels_ && !said(*transfer, s.id())) {
    s.state().fail("the transfer of " + to_string(s.introducer()) + " has updates without a valid signature");
    return;
  }
  for (sync::Transfer::Slot& slot : transfer->slots)
    if (slot.at.is_set()) slot.at = as_seen_from(slot.at, s.introducer());
  if (current_.replica && is_of_this_session(s)) {
    const sync::FoldState* ours = current_.replica->replica().agreed().confirmed_at(then);
    const std::string difference = ours == nullptr ? "" : first_difference(*ours, transfer->state);
    if (!difference.empty()) s.state().tell({.kind = SessionEvent::Kind::kDiffered, .text = difference});
  }
  next_.replica =
      std::make_unique<RecordedReplica>(scene_, replica_config(s), *transfer, std::max(now, then), recording(), sink());
  for (const sync::Transfer::Gone& g : transfer->gone)
    next_.gone.push_back({as_seen_from(g.at, s.introducer()), g.since, g.removed});
  next_.proofs = transfer->proofs;
  catch_up(next_, local);
}

bool Participant::is_of_this_session(const Session& s) const {
  return s.number() == session().number() && s.id() == session().id();
}

void Participant::take_over() {
  Incarnation before = std::move(current_);
  current_ = std::move(next_);
  next_ = {};
  doubts_time_ = false;
  had_.push_back(current_.session->incarnation());
  if (!current_.membership) {
    current_.membership = std::make_unique<Membership>(current_.session->state(), *current_.replica);
    current_.session->hand_over_to(current_.membership.get());
  }
  if (left_at_) plan_farewell();  // leave() was called before its admission
  misses_founder_ = false;
  if (!before.session) return;
  collect(before);
  if (is_of_this_session(*before.session))
    current_.membership->inherit(*before.membership, current_.session->let_in_by().key);
  before.replica->finish(true);
}

// Of several coordinators that leave one after the other, each may be asked just before it leaves.
bool Participant::asks_in_vain(const Endpoint& way_back) const {
  const node::SessionState& s = next_.session->state();
  const Endpoint& asked = *s.config.join;
  return s.phase == SessionPhase::kJoining && asked != way_back && current_.membership->asks_in_vain(asked);
}

// A founder that is started anew founds another session, and in this one play may never begin. While it takes its leave
// it would only pass this peer on.
bool Participant::waits_without_founder() const {
  const auto& join = config_.session.join;
  if (!join || scene_.region || replica().start().wanted == 0) return false;
  for (PeerId p = 0; p < session().slots(); ++p) {
    const bool is_here = replica().seat(p).reachable() && !replica().roster().departed(p);
    if (p == replica().self() || !is_here) continue;
    if (replica().seat(p).incarnation == 0 || same_place(place(p), *join)) return false;
  }
  return true;
}

void Participant::announce_founder_is_gone() {
  if (std::exchange(misses_founder_, true)) return;
  current_.session->state().tell(
      {.kind = SessionEvent::Kind::kReturning, .text = "the founder is gone, and play has not begun"});
}

void Participant::look_for_way_back(Micros local) {
  if (left_at_) return;
  auto where = current_.membership->way_back();
  if (where) current_.membership->announce_way_back();
  const bool elsewhere = !where && waits_without_founder();
  if (elsewhere) {
    announce_founder_is_gone();
    where = config_.session.join;
  }
  note_time(local);
  if (current_.membership->founds_anew() && !next_.replica && !scene_.region) return found_anew(local);
  if (next_.session && !next_.replica && (!where || asks_in_vain(*where))) next_ = {};  // no longer needed
  if (next_.session || local < try_again_ || !where || !where->is_set()) return;
  SessionConfig c = config_.session;
  c.join = *where;
  c.others.clear();
  if (!elsewhere) {
    c.joins = current_.membership->joins_for(*where);
    c.most_offset = most_offset_;
  }
  if (c.joins == 0) return;
  c.seed = derive_seed(c.seed, 0xBAC, ++tries_);
  c.patience = kReturnPatience;
  c.returns = true;
  next_.session = std::make_unique<Session>(c, local);
}

// A session's time does not change: it is not what another introducer says, if most others say that this peer has it.
void Participant::note_time(Micros local) {
  if (doubts_time_) return;
  const Micros offset = session().session_now(local) - local;
  if (const Micros lead = replica().least_clock_lead(); lead >= Replica::kFarAhead)
    most_offset_ = offset - lead;
  else if (replica().shares_time())
    most_offset_ = offset;
}

// Only this peer gives up: the missing ones may still join the members that go on waiting.
void Participant::give_up_waiting(Micros local) {
  const Micros patience = config_.session.patience;
  const sync::Start start = replica().start();
  const int players = session().players();
  const bool all_there = players >= start.wanted;
  if (left_at_ || patience == 0 || all_there || local - began_ < patience) return;
  current_.session->state().failure = "only " + std::to_string(players) + " of " + std::to_string(start.wanted) +
                                      " players came within " + in_seconds(patience);
  leave(local);
}

}  // namespace padr::node
