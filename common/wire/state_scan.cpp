#include "common/wire/state_scan.h"

#include <limits>

#include "common/wire/field_reader.h"

namespace padr::wire {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::uint32_t kFlagsEnd = 1U << 7U;
constexpr std::uint32_t kState = 1U << 4U;

bool count_cause(std::uint64_t flags, StateScan::Update& u) {
  const auto low = static_cast<std::uint32_t>(flags);
  if (low >= kFlagsEnd || (low & 7U) >= sync::kCauses) return false;
  ++u.causes[low & 7U];
  return true;
}

/// The next number of the column that tells of bodies, wherever it stands: it may come in pieces.
class BodyNumbers {
 public:
  explicit BodyNumbers(StateScan::Update& u) : u_(u) {}

  bool take(std::uint64_t number) {
    if (of_claim_ > 0) {
      --of_claim_;
      return true;
    }
    if (bodies_++ == sync::kMaxBodiesPerBundle) return false;
    const std::uint64_t flags = number % kFlagsEnd;
    if ((flags & kState) != 0) of_claim_ = 2;
    return count_cause(flags, u_);
  }
  bool take(Bytes column) {
    for (std::uint64_t number = 0; !column.empty();)
      if (!FieldReader::varint(column, number) || !take(number)) return false;
    return true;
  }
  bool whole() const { return of_claim_ == 0; }

 private:
  StateScan::Update& u_;
  std::size_t bodies_ = 0;
  int of_claim_ = 0;  ///< so many that follow are of the last body's claim
};

bool scan_update(Bytes bytes, const StateScan& mark, StateScan::Update& u) {
  std::uint32_t index_back = 0;
  std::uint32_t tick_back = 0;
  std::uint32_t avatar = 0;
  BodyNumbers bodies(u);
  FieldReader f(bytes);
  while (f.next()) {
    if (f.number == 1 && f.type == 0) index_back = f.u32();
    if (f.number == 2 && f.type == 0) tick_back = f.u32();
    if (f.number == 3 && f.type == 0) avatar = f.u32();
    if (f.number == 4 && f.type == 2 && !bodies.take(f.bytes)) return false;
    if (f.number == 4 && f.type == 0 && !bodies.take(f.value)) return false;
    if (f.number == 10 && f.type == 0) u.leave = f.value != 0;
    if (f.number >= 11 && f.number <= 13 && f.type == 2) u.order = true;
  }
  if (!f.ok() || !bodies.whole() || index_back >= mark.mark_count || tick_back > mark.mark_tick) return false;
  u.index = mark.mark_count - 1 - index_back;
  u.tick = mark.mark_tick - tick_back;
  return avatar == 0 || count_cause(avatar, u);
}

/// The numbers that every datagram has, one after another.
class LinkNumbers {
 public:
  explicit LinkNumbers(StateScan& s)
      : places_{&s.seq,      &s.mark_tick,   &s.mark_count,  &s.have,          &s.seen_seq,
                &s.seen_age, &s.have_beyond, &s.incarnation, &s.to_incarnation} {}

  bool take(std::uint64_t number) {
    if (at_ == places_.size()) return false;
    *places_[at_++] = static_cast<std::uint32_t>(number);
    return true;
  }
  bool take(Bytes column) {
    for (std::uint64_t number = 0; !column.empty();)
      if (!FieldReader::varint(column, number) || !take(number)) return false;
    return true;
  }

 private:
  std::array<std::uint32_t*, 9> places_;
  std::size_t at_ = 0;
};

void take_number(const FieldReader& f, StateScan& s) {
  if (f.number == 8) s.transit = static_cast<std::int32_t>((f.u32() >> 1U) ^ (0U - (f.u32() & 1U)));
  if (f.number == 10) s.check_age = f.u32();
  if (f.number == 12) s.loss = f.u32();
}

}  // namespace

bool scan_state(Bytes payload, StateScan& out) {
  std::vector<StateScan::Update> updates = std::move(out.updates);
  std::vector<Bytes> raw = std::move(out.raw_);
  updates.clear();
  raw.clear();
  out = {};
  LinkNumbers link(out);
  bool good = true;
  FieldReader f(payload);
  while (f.next()) {
    if (f.number == 1 && f.type == 2) good = link.take(f.bytes) && good;
    if (f.number == 1 && f.type == 0) good = link.take(f.value) && good;
    if (f.type == 0) take_number(f, out);
    if (f.type == 5 && f.number == 11) out.check_hash = f.u32();
    if (f.type == 2 && f.number == 9) raw.push_back(f.bytes);
  }
  constexpr auto kMaxTick = static_cast<std::uint32_t>(std::numeric_limits<Tick>::max());
  good =
      good && f.ok() && out.seq != 0 && out.mark_tick < kMaxTick && out.check_age <= out.mark_tick && out.loss <= 100;
  for (const Bytes bytes : raw) {
    StateScan::Update u;
    u.bytes = static_cast<std::uint32_t>(bytes.size() + (bytes.size() < 128 ? 2 : 3));
    good = good && scan_update(bytes, out, u);
    updates.push_back(u);
  }
  out.updates = std::move(updates);
  out.raw_ = std::move(raw);
  return good;
}

}  // namespace padr::wire
