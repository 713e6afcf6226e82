#include "common/membership/membership.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/model/observed_address.h"

namespace padr::node {
namespace {

SessionEvent::Kind kind_of(const MemberChange& c, PeerId self) {
  switch (c.kind) {
    case MemberChange::Kind::kAdmitted:
      return c.slot == self ? SessionEvent::Kind::kAdmitted : SessionEvent::Kind::kJoined;
    case MemberChange::Kind::kLeft:
      return SessionEvent::Kind::kLeft;
    case MemberChange::Kind::kRemoved:
      return SessionEvent::Kind::kLost;
  }
  return {};
}

/// Time for which a machine must report that nobody listens there, with nothing heard from the peer meanwhile.
constexpr Tick kRefused = kTicksPerSecond / 10;
/// Without a key: a link without an answer for so long, ticks, is worth a word if its peer's updates are relayed. By
/// then a peer that has ended has been declared gone.
constexpr Tick kDead = 5 * kTicksPerSecond;

}  // namespace

Membership::Membership(SessionState& session, RecordedReplica& replica)
    : session_(session),
      replica_(replica),
      commands_(session, replica),
      admissions_(session),
      introductions_(session),
      evictions_(session),
      relay_(session),
      misbehaviour_(session),
      merge_(session),
      testimony_(session),
      vouching_(session),
      confirmed_at_(roster().now),
      back_since_(roster().now) {
  replica.set_judge([this](const sync::StatePacket& packet, PeerId by) { return judge(packet, by); });
  count_present();
}

sync::DropReason Membership::judge(const sync::StatePacket& packet, PeerId relayed_by) {
  for (const sync::Bundle& b : packet.updates) testimony_.on_repeat(b, packet.incarnation, view());
  return misbehaviour_.judge(packet, relayed_by, view(), evictions_);
}

bool Membership::bars(const PublicKey& key) const {
  return testimony_.convicts(key) || misbehaviour_.bars(key, view());
}

bool Membership::bars_for_good(const PublicKey& key) const {
  return testimony_.convicts(key) || misbehaviour_.bars_for_good(key);
}

std::string Membership::ban_of(const PublicKey& key) const {
  if (bars_for_good(key)) return "it has been cut off for good";
  const Tick left = misbehaviour_.bars_for(key, view()) + kTicksPerSecond - 1;
  return "it has been cut off, and may come in after " + std::to_string(left / kTicksPerSecond) + " s";
}

void Membership::on_join(const Endpoint& from, const wire::Join& join, Micros local) {
  const View view = this->view();
  const PeerId c = coordinator();
  if (!view.roster.member || c == kNoPeer || way_back()) return;  // the joiner asks again
  if (bars(from.key)) {
    if (commands_.may_answer(local)) commands_.send(from, wire::Refuse{join.nonce, ban_of(from.key)});
    return;
  }
  if (c == session_.self) return admissions_.on_join(from, join, view, local, commands_);
  introductions_.redirect(from, join, view.roster.seats[c].at, local, commands_);
}

void Membership::receive(const Endpoint& from, const wire::Header& header, const wire::MembershipMessage& message,
                         std::size_t bytes, Micros local) {
  const View view = this->view();
  if (const auto* probe = std::get_if<wire::Probe>(&message)) {
    // A ban that ends protects those who are with this peer; if nobody is, it may only keep it alone.
    const bool barred = bars(from.key) && (!merge_.is_alone(view) || bars_for_good(from.key));
    if (!barred)
      merge_.on_probe(from, header.sender, *probe, bytes, view, local, commands_);
    else if (!bars_for_good(from.key))
      merge_.on_probe_of_barred(from, header.sender, *probe, view);
    if (!testimony_.proofs().empty()) testimony_.tell(from, merge_.gone(), view, commands_);
    return;
  }
  if (const auto* pull = std::get_if<wire::Pull>(&message))
    return admissions_.on_pull(
        from, *pull, [this] { return transfer(); }, local, commands_);
  if (const auto* enter = std::get_if<wire::Enter>(&message)) {
    const PeerId c = coordinator();
    if (c != session_.self && c != kNoPeer)
      return admissions_.pass_on(from, *enter, view.roster.seats[c].at, commands_);
    return admissions_.on_enter(from, *enter, view, c == session_.self && !evictions_.busy() && !doubts(), commands_);
  }
  const auto* other = std::get_if<wire::Newcomer>(&message);
  if (other != nullptr && !bars(from.key) && member_with(other->at.key) == kNoPeer)
    merge_.on_told(from, other->at, view);
  if (is_at(header.sender, from) && view.roster.seats[header.sender].reachable()) {
    if (hears(header.sender)) receive_of_member(header.sender, message, local);
  } else if (const auto* fetched = std::get_if<wire::Fetched>(&message); fetched != nullptr && !bars(from.key)) {
    testimony_.on_updates(kNoPeer, *fetched, view);  // what is signed proves a lie, whoever shows it
  }
}

void Membership::receive_of_member(PeerId member, const wire::MembershipMessage& message, Micros local) {
  const View view = this->view();
  if (const auto* poll = std::get_if<wire::Poll>(&message)) {
    const Tick due = std::max(view.roster.now, tick_at(session_.clock.now(local)));
    vouching_.prove_alive(*poll, view, commands_);
    const bool vouched =
        vouching_.vouches(member, *poll, view, due, evictions_.number(), misbehaviour_, relay_, commands_);
    evictions_.on_poll(member, *poll, view, due, vouched, commands_);
  }
  if (const auto* answer = std::get_if<wire::Answer>(&message)) evictions_.on_answer(member, *answer, view, commands_);
  if (const auto* fetch = std::get_if<wire::Fetch>(&message)) relay_.on_fetch(member, *fetch, view, commands_);
  if (const auto* reach = std::get_if<wire::Reach>(&message)) paths_.on_reach(member, *reach, view.roster.now);
  if (const auto* newcomer = std::get_if<wire::Newcomer>(&message)) on_newcomer(member, *newcomer, local);
  if (const auto* fetched = std::get_if<wire::Fetched>(&message)) {
    testimony_.on_updates(member, *fetched, view);
    evictions_.on_fetched(member, *fetched, view, misbehaviour_, commands_);
    relay_.on_fetched(member, *fetched, view, commands_);
  }
}

PeerId Membership::member_with(const PublicKey& key) const {
  for (PeerId p = 0; p < session_.slots; ++p)
    if (const Seat& s = roster().seats[p]; p != session_.self && s.there() && s.at.has_key() && s.at.key == key)
      return p;
  return kNoPeer;
}

void Membership::on_newcomer(PeerId by, const wire::Newcomer& newcomer, Micros local) {
  const Endpoint& at = newcomer.at;
  if (const PeerId p = member_with(at.key); p != kNoPeer && p != by)
    return paths_.note_seen(p, as_seen_from(at, roster().seats[by].at));
  if (coordinator() != session_.self) return;
  misbehaviour_.pardon(at.key);  // the member that tells of it does not bar it
  if (bars(at.key)) return;
  for (const Seat& s : roster().seats)
    if (s.reachable() && (at.has_key() ? s.at.key == at.key : same_place(s.at, at))) return;
  introductions_.on_newcomer(roster().seats[by].at, newcomer, local, commands_);
}

bool Membership::doubts() const {
  for (PeerId p = 0; p < session_.slots; ++p)
    if (p != session_.self && roster().seats[p].there() && Evictions::suspected(view(), p)) return true;
  return false;
}

// The machine of an ended process reports it long before silence shows it. A single report proves nothing: it may
// concern a datagram that arrived before the process started. If others hear it all the same it only cannot be reached
// from here, and the reports go on: until it is heard, they say no more than the first ones.
void Membership::on_unreachable(const Endpoint& at) {
  const Tick now = roster().now;
  for (PeerId p = 0; p < session_.slots; ++p) {
    if (!is_at(p, at) || !roster().seats[p].there()) continue;
    Refused& refused = refused_.try_emplace(p, Refused{now}).first->second;
    if (roster().seats[p].heard >= refused.since) {
      refused = {now};
    } else if (now - refused.since >= kRefused && !refused.believed && !Evictions::suspected(view(), p)) {
      refused.believed = true;
      commands_.tell({.kind = SessionEvent::Kind::kUnreachable, .peer = p});
      commands_.give_up(p, false);
    }
  }
}

// One process is one peer: a peer of another slot at the same address is a former incarnation of it, and has ended. If
// it has another key the process may have started anew; but the address is the word of one member, and two peers on two
// LANs may name the same one. Whoever answers still stays. Several changes may arrive at once, so this is checked after
// all of them: the address of a former occupant says nothing about the present one.
void Membership::note_former_incarnations(const std::vector<MemberChange>& changes) {
  for (const MemberChange& c : changes) {
    if (c.kind != MemberChange::Kind::kAdmitted || c.slot == session_.self) continue;
    for (PeerId p = 0; p < session_.slots; ++p) {
      const Seat& n = roster().seats[p];
      const Endpoint& at = roster().seats[c.slot].at;
      if (p == session_.self || p == c.slot || !same_place(n.at, at) || n.incarnation >= c.incarnation) continue;
      if (n.at.key == at.key)
        former_[p] = n.incarnation;
      else if (n.there())
        commands_.give_up(p, false);
    }
  }
}

// The former incarnation keeps sending until its process knows of the new one; its datagrams are no sign of life.
void Membership::end_former_incarnations() {
  for (auto it = former_.begin(); it != former_.end();) {
    const Seat& n = roster().seats[it->first];
    const bool over = !n.there() || n.incarnation != it->second;
    if (!over && !n.given_up_for_good) commands_.give_up(it->first, true);
    it = over ? former_.erase(it) : std::next(it);
  }
}

sync::Transfer Membership::transfer() const {
  sync::Transfer t = replica_.replica().transfer();
  t.gone = merge_.gone();
  // Of what they have done there may be no proof: a newcomer would believe them, and join them.
  std::erase_if(t.gone, [this](const auto& g) { return misbehaviour_.bars_for_good(g.at.key) && !convicts(g.at.key); });
  t.proofs = testimony_.proofs();
  for (PeerId p = 0; p < session_.slots; ++p) t.slots[p].since = merge_.since(p, view());
  return t;
}

void Membership::follow_changes() {
  const std::vector<MemberChange> changes = replica_.take_changes();
  for (const MemberChange& c : changes) {
    commands_.tell({.kind = kind_of(c, session_.self), .peer = c.slot, .tick = c.tick, .at = c.at});
    if (c.kind == MemberChange::Kind::kAdmitted) {
      evictions_.forget_asker(c.slot);
      misbehaviour_.pardon(c.at.key);
    }
    merge_.on_change(c, view());
    changes_.push_back(c);
  }
  note_former_incarnations(changes);
}

void Membership::take(const std::vector<sync::Transfer::Proof>& proofs) {
  for (const sync::Transfer::Proof& p : proofs) testimony_.take(p);
}

void Membership::follow_testimony() {
  const View view = this->view();
  testimony_.advance(view, commands_);
  for (PeerId p = 0; p < session_.slots; ++p) {
    if (p == session_.self || !roster().seats[p].there() || !testimony_.convicts(roster().seats[p].at.key)) continue;
    misbehaviour_.convict(p, view, commands_);
    evictions_.forget_asker(p);
  }
  const auto liar = testimony_.misled_by();
  if (!liar || roster().leaving || std::exchange(misled_, true)) return;
  misbehaviour_.distrust(*liar, view, commands_);
  evictions_.forget_asker(*liar);
}

void Membership::advance(Micros local) {
  returning_ = admissions_.returning(view());
  const View view = this->view();
  // The others owe nothing to a peer that joins anew: they may have declared it gone.
  if (!told_ && !way_back()) misbehaviour_.advance(view, commands_);
  for (PeerId p = 0; p < session_.slots; ++p)
    if (!misbehaviour_.hears(p, view)) evictions_.forget_asker(p);
  follow_testimony();
  step_down();
  give_up_guide();
  evictions_.advance(view, commands_);
  relay_.advance(view, commands_);
  find_paths();
  follow_changes();
  end_former_incarnations();
  merge_.advance(view, commands_);
  watch_confirmed();
  admissions_.advance(local);
  introductions_.advance(local);
  count_present();
}

// Whoever has come back may have another slot than before, and its address is still that of the former one, too.
PeerId Membership::member_at(const Endpoint& where) const {
  for (PeerId p = 0; p < session_.slots; ++p)
    if (is_at(p, where) && roster().seats[p].reachable()) return p;
  return kNoPeer;
}

bool Membership::may_carry(const Endpoint& from, const Endpoint& to) const {
  const PeerId sender = member_at(from);
  const PeerId receiver = member_at(to);
  return roster().member && sender != kNoPeer && receiver != kNoPeer && hears(sender) && hears(receiver);
}

// Without a key nobody carries, as whoever did could say anything in the name of others. Updates are relayed.
void Membership::find_dead_links() {
  for (PeerId p = 0; p < roster().slots(); ++p) {
    if (p == session_.self) continue;
    const Seat& s = roster().seats[p];
    const Tick unanswered = replica_.replica().link(p).out.unanswered(roster().now);
    const bool was_dead = (dead_links_ & only(p)) != 0;
    const bool is_dead = unanswered >= kDead && (was_dead || roster().now - s.relayed < kDead);
    if (was_dead == (s.there() && is_dead)) continue;
    dead_links_ ^= only(p);
    if (s.there())
      commands_.tell({.kind = was_dead ? SessionEvent::Kind::kDirect : SessionEvent::Kind::kRelayed, .peer = p});
  }
}

void Membership::find_paths() {
  if (!roster().member) return;
  if (!session_.config.sealed) return find_dead_links();
  links_.resize(roster().slots());
  for (PeerId p = 0; p < roster().slots(); ++p) {
    const sync::OutLink& out = replica_.replica().link(p).out;
    const Tick unanswered = out.unanswered(roster().now);
    const bool is_silent = unanswered >= Paths::kUnheard;
    links_[p] = {unanswered, out.round_trip() / 2, is_silent ? relay_.unheard_by(p, roster().now) : PeerSet{0}};
  }
  for (const Paths::Change& c : paths_.advance(roster(), links_)) {
    if (!roster().seats[c.to].there()) continue;
    const auto kind = c.by == kNoPeer ? SessionEvent::Kind::kDirect : SessionEvent::Kind::kCarried;
    commands_.tell({.kind = kind, .peer = c.to, .by = c.by});
    replica_.remark({"way", c.to, c.by == kNoPeer ? "direct" : "by " + std::to_string(c.by)});
  }
  auto telling = paths_.due(roster(), links_);
  if (!telling) return;
  telling->reach.at = session_.config.own_addresses;
  for (PeerId p = 0; p < roster().slots(); ++p)
    if ((telling->to & only(p)) != 0 && roster().seats[p].reachable())
      commands_.send(roster().seats[p].at, telling->reach);
}

void Membership::count_present() {
  const Replica& replica = replica_.replica();
  const bool region = replica.live().world().scene().region.has_value();
  int present = 0;
  int spectators = 0;
  for (PeerId p = 0; p < session_.slots; ++p) {
    if (p != session_.self && !roster().seats[p].there()) continue;
    ++present;
    // This peer counts as one also once it has said goodbye.
    const bool watches =
        p == session_.self ? session_.config.spectates : replica.agreed().predicted_state().spectates(p);
    if (!region && watches) ++spectators;
  }
  commands_.count_present(present, spectators);
}

std::vector<MemberChange> Membership::take_changes() {
  return std::exchange(changes_, {});
}

}  // namespace padr::node
