#include "common/membership/testimony.h"

#include <algorithm>

#include "common/sync/validation.h"
#include "common/wire/codec.h"
#include "common/wire/signature.h"

namespace padr::node {
namespace {

using sync::Bundle;

/// Most datagrams of testimony in one go.
constexpr int kAtOnce = 12;

/// The key of the peer known by that incarnation.
std::optional<PublicKey> known_key(PeerId slot, std::uint32_t incarnation, const View& view) {
  const Seat& s = view.roster.seats[slot];
  if (s.incarnation == incarnation && s.at.has_key()) return s.at.key;
  for (const Former& f : s.former)
    if (f.incarnation == incarnation && f.at.has_key()) return f.at.key;
  return std::nullopt;
}

/// The kept update that a known one contradicts; null if there is none.
const Bundle* rival(const Bundle& b, const sync::UpdateLog& log) {
  const Bundle* kept = log.find_at(b.peer, b.tick);
  if (kept == nullptr && log.knows(b.peer, b.index)) kept = log.find(b.peer, b.index);
  if (kept == nullptr) kept = log.find_out_of_order(b.peer, b.index, b.tick);
  return kept == nullptr || *kept == b || !wire::contradict(*kept, b) ? nullptr : kept;
}

/// Whether a transfer can tell of this update. With others a proof would be one that no joiner can read.
bool has_form_in_transfer(const Bundle& b) {
  return b.index < sync::kEndOfNumbers;
}

}  // namespace

bool Testimony::convicts(const PublicKey& key) const {
  return std::any_of(proofs_.begin(), proofs_.end(), [&](const Proof& p) { return p.key == key; });
}

bool Testimony::may_check(PeerId from, const View& view) {
  Checks& c = checks_[from];
  if (view.roster.now - c.since >= kTicksPerSecond) c = {view.roster.now, 0};
  return ++c.made <= kMostChecks;
}

bool Testimony::is_new(const Proof& proof) const {
  return !convicts(proof.key) && proof.incarnation < sync::kEndOfNumbers && has_form_in_transfer(proof.one) &&
         has_form_in_transfer(proof.other) && wire::is_proven(session_.id, proof);
}

void Testimony::take(const Proof& proof) {
  if (proofs_.size() < sync::Transfer::kMostProofs && is_new(proof)) proofs_.push_back(proof);
}

// Whoever knows the proof has barred that key already.
void Testimony::forget_absent(const View& view) {
  const auto is_absent = [&](const Proof& p) {
    return std::none_of(view.roster.seats.begin(), view.roster.seats.end(),
                        [&](const Seat& s) { return s.there() && s.at.key == p.key; });
  };
  const auto it = std::find_if(proofs_.begin(), proofs_.end(), is_absent);
  if (it != proofs_.end()) proofs_.erase(it);
}

void Testimony::accuse(PeerId from, std::uint32_t incarnation, const Bundle& one, const Bundle& other,
                       const View& view) {
  const auto known = known_key(one.peer, incarnation, view);
  if (known && convicts(*known)) return;
  if (!may_check(from, view)) return;
  const auto try_key = [&](const PublicKey& key) {
    const Proof proof{key, incarnation, one, other};
    if (!is_new(proof)) return;
    if (proofs_.size() == sync::Transfer::kMostProofs) forget_absent(view);
    if (proofs_.size() < sync::Transfer::kMostProofs) proofs_.push_back(proof);
  };
  if (known) try_key(*known);
  // Another part may have known somebody else by it, and a liar may sign in another peer's name. In no name does an
  // honest peer sign two updates of one number: what convinces one member has to convince all.
  for (const Seat& s : view.roster.seats)
    if (s.there() && s.at.has_key() && s.at.key != known) try_key(s.at.key);
}

void Testimony::compare(PeerId from, const Bundle& update, std::uint32_t incarnation, const View& view) {
  if (const Bundle* kept = rival(update, view.log)) accuse(from, incarnation, *kept, update, view);
  note_broken_promise(from, update, incarnation, view);
  const auto before = pending_.find(from);
  if (before != pending_.end() && before->second.incarnation == incarnation &&
      wire::contradict(before->second.update, update))
    accuse(from, incarnation, before->second.update, update, view);
  pending_[from] = {incarnation, update};
}

// Its mark for this peer was a lie, and a mark is not signed: nobody else can be shown that.
void Testimony::note_broken_promise(PeerId from, const Bundle& update, std::uint32_t incarnation, const View& view) {
  const sync::UpdateLog& log = view.log;
  const PeerId p = update.peer;
  const Seat& s = view.roster.seats[p];
  if (p == session_.self || misled_by_ || s.incarnation != incarnation || log.closed(p) || log.knows(p, update.index))
    return;
  if (update.tick > log.complete(p) || update.index < s.first || !may_check(from, view)) return;
  if (wire::is_signed(s.at.key, {session_.id, incarnation}, update)) misled_by_ = p;
}

void Testimony::on_updates(PeerId from, const wire::Fetched& sent, const View& view) {
  if (!session_.config.sealed || sent.slot >= session_.slots) return;
  for (const Bundle& b : sent.updates) compare(from, b, sent.incarnation, view);
}

void Testimony::on_repeat(const Bundle& update, std::uint32_t incarnation, const View& view) {
  if (!session_.config.sealed || !view.log.knows(update.peer, update.index)) return;
  if (const Bundle* kept = rival(update, view.log)) accuse(update.peer, incarnation, *kept, update, view);
}

// It happened after the last tick of which both had the same world.
void Testimony::testify(PeerId to, const View& view, Commands& out) {
  const Seat& other = view.roster.seats[to];
  int sent = 0;
  for (PeerId p = 0; p < view.roster.slots(); ++p) {
    if (p == to || p == session_.self) continue;
    wire::Fetched all{p, view.roster.seats[p].incarnation, {}};
    std::size_t used = wire::kStateOverhead;
    const auto send = [&] {
      if (!all.updates.empty() && sent++ < kAtOnce) out.send(other.at, all);
      all.updates.clear();
      used = wire::kStateOverhead;
    };
    for (const Bundle& b : view.log.since(std::max(0, other.same))) {
      if (b.peer != p || b.tick >= other.differs_at || b.index < view.roster.seats[p].first) continue;
      const std::size_t size = wire::encoded_size(b);
      if (used + size > wire::kMaxPayload) send();
      all.updates.push_back(b);
      used += size;
    }
    send();
  }
}

// As long as the liar is there: the others may not know, because they were elsewhere when it lied.
void Testimony::make_known(const View& view, Commands& out) {
  const Proof* found = nullptr;
  for (const Seat& s : view.roster.seats)
    for (const Proof& p : proofs_)
      if (s.there() && s.at.key == p.key) found = &p;
  if (found == nullptr || found->key != known_) since_ = view.roster.now;
  known_ = found == nullptr ? PublicKey{} : found->key;
  if (found == nullptr || view.roster.now - since_ > kMadeKnown || view.roster.now - told_ < kAgain) return;
  told_ = view.roster.now;
  for (PeerId q = 0; q < view.roster.slots(); ++q) {
    const Seat& to = view.roster.seats[q];
    if (q == session_.self || !to.there() || convicts(to.at.key)) continue;
    for (const Bundle* b : {&found->one, &found->other})
      out.send(to.at, wire::Fetched{b->peer, found->incarnation, {*b}});
  }
}

void Testimony::tell(const Endpoint& to, const std::vector<sync::Transfer::Gone>& gone, const View& view,
                     Commands& out) {
  if (!view.roster.member || convicts(to.key) || view.roster.now - told_outside_ < kAgain) return;
  for (const Proof& p : proofs_) {
    if (std::none_of(gone.begin(), gone.end(), [&](const auto& g) { return g.at.key == p.key; })) continue;
    told_outside_ = view.roster.now;
    for (const Bundle* b : {&p.one, &p.other}) out.send(to, wire::Fetched{b->peer, p.incarnation, {*b}});
  }
}

void Testimony::advance(const View& view, Commands& out) {
  if (!session_.config.sealed || !view.roster.member) return;
  for (PeerId q = 0; q < view.roster.slots(); ++q) {
    const Seat& s = view.roster.seats[q];
    if (q == session_.self || !s.there() || !s.differs) continue;
    Dispute& d = disputes_[q];
    if (d.incarnation != s.incarnation) d = {s.incarnation, 0, 0};
    if (d.times >= kTimes || view.roster.now < d.next) continue;
    ++d.times;
    d.next = view.roster.now + kAgain;
    testify(q, view, out);
  }
  make_known(view, out);
}

}  // namespace padr::node
