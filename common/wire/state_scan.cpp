#include "common/wire/state_scan.h"

#include <limits>

#include "common/wire/field_reader.h"

namespace padr::wire {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::uint32_t kFlagsEnd = 1U << 7U;

bool count_cause(std::uint64_t flags, StateScan::Update& u) {
  const auto low = static_cast<std::uint32_t>(flags);
  if (low >= kFlagsEnd || (low & 7U) >= sync::kCauses) return false;
  ++u.causes[low & 7U];
  return true;
}

bool scan_flags(Bytes column, StateScan::Update& u) {
  std::size_t n = 0;
  for (std::uint64_t flags = 0; !column.empty(); ++n)
    if (n == sync::kMaxBodiesPerBundle || !FieldReader::varint(column, flags) || !count_cause(flags, u)) return false;
  return true;
}

bool scan_update(Bytes bytes, const StateScan& mark, StateScan::Update& u) {
  std::uint32_t index_back = 0;
  std::uint32_t tick_back = 0;
  std::uint32_t avatar = 0;
  FieldReader f(bytes);
  while (f.next()) {
    if (f.number == 1 && f.type == 0) index_back = f.u32();
    if (f.number == 2 && f.type == 0) tick_back = f.u32();
    if (f.number == 3 && f.type == 0) avatar = f.u32();
    if (f.number == 6 && f.type == 2 && !scan_flags(f.bytes, u)) return false;
    if (f.number == 6 && f.type == 0 && !count_cause(f.value, u)) return false;
    if (f.number == 10 && f.type == 0) u.leave = f.value != 0;
    if (f.number >= 11 && f.number <= 13 && f.type == 2) u.order = true;
  }
  if (!f.ok() || index_back >= mark.mark_count || tick_back > mark.mark_tick) return false;
  u.index = mark.mark_count - 1 - index_back;
  u.tick = mark.mark_tick - tick_back;
  return avatar == 0 || count_cause(avatar, u);
}

void take_number(const FieldReader& f, StateScan& s) {
  switch (f.number) {
    case 1:
      s.seq = f.u32();
      break;
    case 2:
      s.mark_tick = f.u32();
      break;
    case 3:
      s.mark_count = f.u32();
      break;
    case 4:
      s.have = f.u32();
      break;
    case 6:
      s.seen_seq = f.u32();
      break;
    case 7:
      s.seen_age = f.u32();
      break;
    case 8:
      s.transit = static_cast<std::int32_t>((f.u32() >> 1U) ^ (0U - (f.u32() & 1U)));
      break;
    case 10:
      s.check_age = f.u32();
      break;
    case 12:
      s.loss = f.u32();
      break;
    case 13:
      s.incarnation = f.u32();
      break;
    case 14:
      s.to_incarnation = f.u32();
      break;
    default:
      break;
  }
}

}  // namespace

bool scan_state(Bytes payload, StateScan& out) {
  std::vector<StateScan::Update> updates = std::move(out.updates);
  std::vector<Bytes> raw = std::move(out.raw_);
  updates.clear();
  raw.clear();
  out = {};
  FieldReader f(payload);
  while (f.next()) {
    if (f.type == 0) take_number(f, out);
    if (f.type == 5 && f.number == 5) out.have_beyond = f.u32();
    if (f.type == 5 && f.number == 11) out.check_hash = f.u32();
    if (f.type == 2 && f.number == 9) raw.push_back(f.bytes);
  }
  constexpr auto kMaxTick = static_cast<std::uint32_t>(std::numeric_limits<Tick>::max());
  bool good = f.ok() && out.seq != 0 && out.mark_tick < kMaxTick && out.check_age <= out.mark_tick && out.loss <= 100;
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
