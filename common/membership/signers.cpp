#include "common/membership/signers.h"

#include <algorithm>

#include "common/wire/signature.h"

namespace padr::node {

using sync::Bundle;

std::optional<Sayer> sayer(PeerId p, std::uint32_t index, const View& view, const Admitted& meanwhile) {
  for (auto a = meanwhile.rbegin(); a != meanwhile.rend(); ++a)
    if ((*a)->slot == p && index >= (*a)->first) return Sayer{(*a)->incarnation, (*a)->at.key};
  const Seat& n = view.roster.seats[p];
  if (index >= n.first && p != view.roster.self)
    return n.at.has_key() ? std::optional(Sayer{n.incarnation, n.at.key}) : std::nullopt;
  for (auto f = n.former.rbegin(); f != n.former.rend(); ++f)
    if (index >= f->first && f->at.has_key()) return Sayer{f->incarnation, f->at.key};
  return std::nullopt;
}

std::optional<Sayer> missing_signer(const Bundle& b, const View& view, const Admitted& meanwhile) {
  if (view.log.knows(b.peer, b.index)) return std::nullopt;
  const auto who = sayer(b.peer, b.index, view, meanwhile);
  if (who && wire::is_signed(who->key, {view.roster.session, who->incarnation}, b)) return std::nullopt;
  return who;
}

Signed is_signed(const Bundle& b, bool passed_on, const View& view, Admitted& meanwhile) {
  // A peer that passes on an update of a slot may know of a newer occupant that we have not heard of yet. Its own are
  // by the occupant that we know.
  if (missing_signer(b, view, passed_on ? meanwhile : Admitted{})) return passed_on ? Signed::kUnclear : Signed::kNo;
  // Nobody is known to have sat there yet. Of times before this peer came, that is no objection.
  const bool of_now = b.peer != view.roster.self && b.index >= view.roster.seats[b.peer].first;
  if (passed_on && of_now && !view.log.knows(b.peer, b.index) && !sayer(b.peer, b.index, view, meanwhile))
    return Signed::kUnclear;
  if (b.admission) meanwhile.push_back(&*b.admission);
  for (const Bundle& lost : b.passed_on)
    if (const Signed is = is_signed(lost, true, view, meanwhile); is != Signed::kYes) return is;
  return Signed::kYes;
}

std::vector<Bundle> waiting_admissions(const sync::StatePacket& packet, const View& view) {
  std::vector<Bundle> all;
  if (std::all_of(packet.updates.begin(), packet.updates.end(), [](const Bundle& b) { return b.passed_on.empty(); }))
    return all;
  for (PeerId p = 0; p < view.roster.slots(); ++p)
    for (const Bundle& b : view.log.of(p, view.log.have(p)))
      if (b.admission) all.push_back(b);
  return all;
}

int signatures_in(const Bundle& b, const View& view) {
  if (view.log.knows(b.peer, b.index)) return 0;
  int all = 1;
  for (const Bundle& lost : b.passed_on) all += signatures_in(lost, view);
  return all;
}

bool said(const sync::Transfer& transfer, const SessionId& session) {
  struct Sitter {
    std::uint32_t first = 0;
    Sayer who;
  };
  std::vector<std::vector<Sitter>> seats(transfer.slots.size());
  for (std::size_t p = 0; p < seats.size(); ++p)
    seats[p].push_back({0, {transfer.state.members[p].incarnation, transfer.slots[p].at.key}});
  // The address is that of the latest peer in the slot; the transfer has no key of earlier ones.
  const auto note = [&](const Bundle& b) {
    if (!b.admission || b.admission->slot >= seats.size()) return;
    std::vector<Sitter>& s = seats[b.admission->slot];
    if (b.admission->incarnation <= s.back().who.incarnation) return;
    s.front().who.key = {};
    s.push_back({b.admission->first, {b.admission->incarnation, b.admission->at.key}});
  };
  for (const Bundle& b : transfer.tail) {
    note(b);
    for (const Bundle& lost : b.passed_on) note(lost);
  }
  return std::all_of(transfer.tail.begin(), transfer.tail.end(), [&](const Bundle& b) {
    const auto& s = seats[b.peer];
    const auto sitter = std::find_if(s.rbegin(), s.rend(), [&b](const Sitter& at) { return b.index >= at.first; });
    return sitter == s.rend() || sitter->who.key == PublicKey{} ||
           wire::is_signed(sitter->who.key, {session, sitter->who.incarnation}, b);
  });
}

}  // namespace padr::node
