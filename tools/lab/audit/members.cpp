#include "tools/lab/audit/members.h"

#include <algorithm>

namespace padr::lab::audit {
namespace {

bool are_one(const Member& a, const Member& b) {
  if (a.slot != b.slot || a.incarnation != b.incarnation) return false;
  if (a.has_key() && b.has_key()) return a.key == b.key;
  return a.since < 0 || b.since < 0 || a.since == b.since;
}

}  // namespace

MemberId Members::find_or_add(const Member& member) {
  const auto found = std::find_if(all_.begin(), all_.end(), [&](const Member& m) { return are_one(m, member); });
  if (found == all_.end()) {
    all_.push_back(member);
    return all_.size() - 1;
  }
  if (!found->has_key()) found->key = member.key;
  if (found->since < 0) found->since = member.since;
  return static_cast<MemberId>(found - all_.begin());
}

MemberId Members::note(std::size_t trace, const Member& member, std::uint32_t first) {
  const MemberId id = find_or_add(member);
  std::vector<Seat>& of_slot = seats_[trace][member.slot];
  const auto known = std::find_if(of_slot.begin(), of_slot.end(), [id](const Seat& s) { return s.member == id; });
  if (known == of_slot.end())
    of_slot.push_back({first, id});
  else
    known->first = std::max(known->first, first);
  return id;
}

void Members::note_admission(std::size_t trace, const sync::Admission& a, Tick tick) {
  note(trace, {a.slot, a.incarnation, a.at.key, tick}, a.first);
}

// Addresses and keys in a transfer are those of whoever sits there at its end. Its sender does not tell its own tick.
void Members::note_transfer(std::size_t trace, const sync::Transfer& start) {
  for (PeerId p = 0; p < start.state.members.size(); ++p) {
    const sync::Member& there = start.state.members[p];
    if (!there.present) continue;
    const bool replaced = std::any_of(start.tail.begin(), start.tail.end(),
                                      [p](const sync::Bundle& b) { return b.admission && b.admission->slot == p; });
    Member m{p, there.incarnation, {}, -1};
    if (!replaced) m.key = start.slots[p].at.key;
    if (!replaced && (start.slots[p].since > 0 || m.incarnation == 0)) m.since = start.slots[p].since;
    note(trace, m, 0);
  }
}

std::optional<MemberId> Members::sitter(std::size_t trace, PeerId slot, std::uint32_t incarnation) const {
  const auto of_slot = seats_[trace].find(slot);
  if (of_slot == seats_[trace].end()) return std::nullopt;
  const auto& seats = of_slot->second;
  const auto found = std::find_if(seats.rbegin(), seats.rend(),
                                  [&](const Seat& s) { return all_[s.member].incarnation == incarnation; });
  return found == seats.rend() ? std::nullopt : std::optional(found->member);
}

std::optional<MemberId> Members::author(std::size_t trace, PeerId slot, std::uint32_t index) const {
  const auto of_slot = seats_[trace].find(slot);
  if (of_slot == seats_[trace].end()) return std::nullopt;
  const Seat* best = nullptr;
  for (const Seat& s : of_slot->second) {
    const bool later = best == nullptr || s.first > best->first ||
                       (s.first == best->first && all_[s.member].incarnation > all_[best->member].incarnation);
    if (s.first <= index && later) best = &s;
  }
  return best == nullptr ? std::nullopt : std::optional(best->member);
}

}  // namespace padr::lab::audit
