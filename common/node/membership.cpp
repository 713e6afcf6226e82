#include "common/node/membership.h"

#include <iterator>
#include <utility>

namespace padr::node {
namespace {

/// The confirmed world may wait until a peer is declared gone; only a longer wait means that this peer is stuck.
constexpr Tick kStuck = 12 * kTicksPerSecond;
/// That nobody listens there has to be said for so long, and nothing heard meanwhile.
constexpr Tick kRefused = kTicksPerSecond / 10;

}  // namespace

Membership::Membership(SessionDesk& desk, RecordedNode& node)
    : desk_(desk), node_(node), doorkeeper_(desk), removals_(desk), relay_(desk), guard_(desk), sides_(desk) {
  desk_.roster.resize(static_cast<std::size_t>(desk.slots));
  for (PeerId p = 0; p < desk_.roster.size(); ++p) node.locate(p, desk_.roster[p]);
  node.set_judge([this](const sync::StatePacket& packet) { return guard_.judge(packet, node_.node(), removals_); });
}

void Membership::on_join(const Endpoint& from, const wire::Join& join, Micros local) {
  const PeerId c = coordinator();
  if (!node_.node().member() || c == kNoPeer || way_back()) return;  // it asks again
  if (guard_.bars(from.key, node_.node())) {
    if (desk_.may_answer(local)) desk_.send(from, wire::Refuse{join.nonce, "it has been cut off"});
    return;
  }
  if (c == desk_.self) return doorkeeper_.on_join(from, join, node_, local);
  if (desk_.may_answer(local)) desk_.send(from, wire::Redirect{join.nonce, desk_.roster[c]});
}

std::optional<PeerId> Membership::sender(const Endpoint& from, const wire::Header& header) const {
  if (header.sender >= desk_.roster.size() || header.sender == desk_.self || desk_.roster[header.sender] != from ||
      !node_.node().other(header.sender).reachable())
    return std::nullopt;
  return header.sender;
}

void Membership::receive(const Endpoint& from, const wire::Header& header, const wire::MembershipMessage& message,
                         std::size_t bytes, Micros local) {
  if (const auto* probe = std::get_if<wire::Probe>(&message))
    return sides_.on_probe(from, header.sender, *probe, bytes, node_.node(), local);
  if (const auto* pull = std::get_if<wire::Pull>(&message))
    return doorkeeper_.on_pull(from, *pull, node_, sides_.gone());
  if (const auto* enter = std::get_if<wire::Enter>(&message)) {
    const PeerId c = coordinator();
    if (c != desk_.self && c != kNoPeer) return doorkeeper_.pass_on(from, *enter, desk_.roster[c]);
    return doorkeeper_.on_enter(from, *enter, node_, c == desk_.self && !removals_.busy() && !doubts());
  }
  const auto member = sender(from, header);
  if (!member || !hears(*member)) return;
  if (const auto* poll = std::get_if<wire::Poll>(&message)) removals_.on_poll(*member, *poll, node_);
  if (const auto* answer = std::get_if<wire::Answer>(&message)) removals_.on_answer(*member, *answer, node_.node());
  if (const auto* fetch = std::get_if<wire::Fetch>(&message)) {
    removals_.on_fetch(*member, *fetch, node_.node());
    relay_.on_fetch(*member, *fetch, node_.node());
  }
  if (const auto* fetched = std::get_if<wire::Fetched>(&message)) {
    removals_.on_fetched(*fetched, node_.node(), guard_);
    relay_.on_fetched(*member, *fetched, node_);
  }
}

bool Membership::doubts() const {
  const Node& n = node_.node();
  for (PeerId p = 0; p < n.config().slots; ++p)
    if (p != desk_.self && n.other(p).there() && Removals::suspected(n, p)) return true;
  return false;
}

// Where a process has ended, its machine says so long before silence does. One word may be of a datagram that was there
// before the process was.
void Membership::on_unreachable(const Endpoint& at) {
  const Node& n = node_.node();
  for (PeerId p = 0; p < desk_.roster.size(); ++p) {
    if (p == desk_.self || desk_.roster[p] != at || !n.other(p).there()) continue;
    Tick& since = refused_.try_emplace(p, n.now()).first->second;
    if (n.other(p).heard >= since) {
      since = n.now();
    } else if (n.now() - since >= kRefused && !Removals::suspected(n, p)) {
      desk_.note("nobody listens at peer " + std::to_string(p) + "'s address any more", true);
      node_.give_up(p, false);
    }
  }
}

// One process is one peer: if another slot's was there, that life of it is over. Several may come to be known at once,
// so this is asked when all of them are: where somebody was who sat there before says nothing of who does now.
void Membership::note_former_lives(const std::vector<MemberChange>& changes) {
  for (const MemberChange& c : changes) {
    if (c.kind != MemberChange::Kind::kAdmitted || c.slot == desk_.self) continue;
    for (PeerId p = 0; p < desk_.roster.size(); ++p)
      if (p != desk_.self && p != c.slot && same_place(desk_.roster[p], desk_.roster[c.slot]) &&
          node_.node().other(p).incarnation < c.incarnation)
        former_[p] = node_.node().other(p).incarnation;
  }
}

// Until it knows that it has been let in anew it goes on as before, and what it says meanwhile is no sign of life.
void Membership::end_former_lives() {
  for (auto it = former_.begin(); it != former_.end();) {
    const Neighbour& n = node_.node().other(it->first);
    const bool over = !n.there() || n.incarnation != it->second;
    if (!over && !n.given_up_for_good) node_.give_up(it->first);
    it = over ? former_.erase(it) : std::next(it);
  }
}

void Membership::follow_changes() {
  const std::vector<MemberChange> changes = node_.take_changes();
  for (const MemberChange& c : changes) {
    const std::string who = "peer " + std::to_string(c.slot);
    if (c.kind == MemberChange::Kind::kAdmitted && c.slot != desk_.self) {
      desk_.roster[c.slot] = c.at;
      desk_.note(who + " at " + to_string(c.at) + " joins at tick " + std::to_string(c.tick));
    }
    if (c.kind == MemberChange::Kind::kAdmitted && c.slot == desk_.self)
      desk_.note("admitted at tick " + std::to_string(c.tick) + " as " + who);
    if (c.kind == MemberChange::Kind::kLeft) desk_.note(who + " has left");
    if (c.kind == MemberChange::Kind::kRemoved)
      desk_.note(who + " is lost: out from tick " + std::to_string(c.tick), true);
    if (c.kind == MemberChange::Kind::kAdmitted) removals_.forget_asker(c.slot);
    sides_.on_change(c);
    changes_.push_back(c);
  }
  note_former_lives(changes);
}

void Membership::advance(Micros local) {
  guard_.advance(node_, removals_);
  removals_.advance(node_);
  relay_.advance(node_.node());
  follow_changes();
  end_former_lives();
  sides_.advance(node_.node());
  watch_confirmed();
  doorkeeper_.advance(local);
  int present = 1;
  for (PeerId p = 0; p < desk_.roster.size(); ++p)
    if (p != desk_.self && node_.node().other(p).there()) ++present;
  desk_.present = present;
}

std::vector<MemberChange> Membership::take_changes() {
  return std::exchange(changes_, {});
}

void Membership::watch_confirmed() {
  const Tick confirmed = node_.node().agreed().confirmed().tick;
  if (confirmed != confirmed_) confirmed_at_ = node_.node().now();
  confirmed_ = confirmed;
}

bool Membership::stuck() const {
  return node_.node().now() - confirmed_at_ > kStuck;
}

// Who agrees with the coordinator is right, whoever else says otherwise.
std::string Membership::why_back() const {
  const Node& n = node_.node();
  const PeerId c = coordinator();
  if (c == desk_.self || c == kNoPeer) return "";
  if (n.other(c).differs)
    return "CONFIRMED WORLDS DIFFER from peer " + std::to_string(c) + "'s at tick " +
           std::to_string(n.stats().first_mismatch);
  if (stuck()) return "nothing has been confirmed for " + std::to_string(kStuck / kTicksPerSecond) + " s";
  return n.expelled() ? "the others have declared this peer gone" : "";
}

std::optional<Endpoint> Membership::way_back() const {
  const Node& n = node_.node();
  if (n.leaving()) return std::nullopt;
  if (const auto winner = sides_.winner(n)) return winner;
  if (why_back().empty()) return std::nullopt;
  return desk_.roster[coordinator()];
}

void Membership::announce_way_back() {
  const std::string why = why_back();
  if (!why.empty() && !std::exchange(told_, true)) desk_.note(why + ": joining anew", true);
}

}  // namespace padr::node
