#include "common/wire/passage_codec.h"

#include <limits>
#include <set>

#include "common/wire/value_column.h"
#include "proto/wire.pb.h"

namespace padr::wire {
namespace {

constexpr unsigned kKinds = 3U;
constexpr unsigned kOwned = 1U << 2U;
constexpr unsigned kAwake = 1U << 3U;
constexpr unsigned kBuildShift = 4;
constexpr unsigned kFlagsEnd = 1U << 12U;
constexpr unsigned kStays = 1U;
constexpr unsigned kGoes = 2U;
using Kind = sync::Passage::Kind;
constexpr std::uint32_t kMostNumber = 0xFFFF;
constexpr std::uint32_t kMostCrossings = 1U << 30U;

bool take_state(const Passage& in, sync::Passage& out) {
  out.state.awake = (in.flags() & kAwake) != 0;
  ValueColumn<Passage> values(in);
  return values.take(out.state) && values.used_up();
}

bool take_passage(const Passage& in, sync::Passage& out) {
  if (in.number() > kMostNumber || in.crossings() == 0 || in.crossings() >= kMostCrossings) return false;
  out.name = {in.region(), static_cast<std::uint16_t>(in.number())};
  out.crossings = in.crossings();
  const unsigned flags = in.flags();
  if (flags >= kFlagsEnd) return false;
  if ((flags & kKinds) > static_cast<unsigned>(Kind::kOut)) return false;
  out.kind = static_cast<Kind>(flags & kKinds);
  out.to = in.to();
  if (out.kind != Kind::kBound && out.to != 0) return false;
  if (out.kind != Kind::kIn) return flags <= kKinds && in.state().empty() && in.rounded().empty();
  out.owned = (flags & kOwned) != 0;
  out.build = static_cast<std::uint8_t>(flags >> kBuildShift);
  return take_state(in, out);
}

}  // namespace

void put_passages(const sync::Bundle& b, Update& out) {
  if (b.going) out.set_going(*b.going ? kGoes : kStays);
  for (const sync::Passage& p : b.passages) {
    Passage& to = *out.add_passages();
    to.set_region(p.name.region);
    to.set_number(p.name.number);
    to.set_crossings(p.crossings);
    to.set_to(p.to);
    to.set_flags(static_cast<unsigned>(p.kind));
    if (p.kind != Kind::kIn) continue;
    to.set_flags(static_cast<unsigned>(p.kind) | (p.owned ? kOwned : 0) | (p.state.awake ? kAwake : 0) |
                 unsigned{p.build} << kBuildShift);
    put_values(p.state, to);
  }
}

bool take_passages(const Update& in, sync::Bundle& out) {
  if (in.going() > kGoes) return false;
  if (in.going() != 0) out.going = in.going() == kGoes;
  if (static_cast<std::size_t>(in.passages_size()) > sync::kMaxPassages) return false;
  for (const Passage& p : in.passages())
    if (!take_passage(p, out.passages.emplace_back())) return false;
  return true;
}

void put_residents(const sync::Residents& r, Transfer& out) {
  for (const sync::Resident& s : r.slots) {
    Transfer::Resident& to = *out.add_residents();
    to.set_region(s.name.region);
    to.set_number(s.name.number);
    to.set_crossings(s.crossings);
    to.set_present(s.present);
    to.set_bound(s.bound);
  }
  for (const sync::Residents::Gone& g : r.gone) {
    Transfer::Resident& to = *out.add_went();
    to.set_region(g.name.region);
    to.set_number(g.name.number);
    to.set_crossings(g.crossings);
    to.set_at(static_cast<std::uint32_t>(g.at));
  }
}

bool take_residents(const Transfer& in, std::size_t slots, sync::Residents& out) {
  if (static_cast<std::size_t>(in.residents_size()) != slots) return false;
  if (static_cast<std::size_t>(in.went_size()) > (slots > 0 ? sync::Residents::kMostGone : 0)) return false;
  std::set<sync::BodyName> seen;
  for (const Transfer::Resident& r : in.residents()) {
    if (r.number() > kMostNumber || r.crossings() >= kMostCrossings || r.at() != 0) return false;
    const sync::Resident s{r.present(), {r.region(), static_cast<std::uint16_t>(r.number())}, r.crossings(), r.bound()};
    // One body is in one slot, and in an empty one there is nothing.
    if (s.present ? !seen.insert(s.name).second : s != sync::Resident{}) return false;
    out.slots.push_back(s);
  }
  for (const Transfer::Resident& g : in.went()) {
    if (g.number() > kMostNumber || g.crossings() == 0 || g.crossings() >= kMostCrossings || g.present() ||
        g.bound() != 0)
      return false;
    if (g.at() > in.tick() || (!out.gone.empty() && g.at() < static_cast<std::uint32_t>(out.gone.back().at)))
      return false;
    out.gone.push_back(
        {{g.region(), static_cast<std::uint16_t>(g.number())}, g.crossings(), static_cast<Tick>(g.at())});
  }
  return true;
}

}  // namespace padr::wire
