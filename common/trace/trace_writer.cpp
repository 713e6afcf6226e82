#include "common/trace/trace_writer.h"

#include <bit>
#include <cassert>
#include <utility>

#include "common/trace/trace_format.h"

namespace padr::trace {
namespace {

/// Ids of ascending entities as gaps.
class Gaps {
 public:
  std::uint32_t next(std::size_t e) {
    const auto gap = static_cast<std::uint32_t>(e) - expected_;
    expected_ = static_cast<std::uint32_t>(e) + 1;
    return gap;
  }

 private:
  std::uint32_t expected_ = 0;
};

void put_changes(const std::vector<BodyState>& now, std::vector<BodyState>& told, file::Step& out) {
  Gaps gaps;
  for (std::size_t e = 0; e < now.size(); ++e) {
    const auto values = fields_of(now[e]);
    const auto before = fields_of(told[e]);
    std::uint32_t fields = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      // By bits: 0 and -0 are told apart, and so is whatever else a float may hold.
      if (std::bit_cast<std::uint32_t>(values[i]) != std::bit_cast<std::uint32_t>(before[i])) fields |= 1U << i;
    if (fields == 0 && now[e].awake == told[e].awake) continue;
    out.add_changed(gaps.next(e));
    out.add_changed_fields(fields | (now[e].awake ? kAwakeBit : 0U));
    for (std::size_t i = 0; i < values.size(); ++i)
      if ((fields & (1U << i)) != 0) out.add_values(values[i]);
    told[e] = now[e];
  }
}

void put_shown(const LiveView& live, file::Step& out) {
  Gaps gaps;
  for (std::size_t e = 0; e < live.states.size(); ++e) {
    if (live.shown[e] == live.states[e].position) continue;
    out.add_shown(gaps.next(e));
    out.add_shown_at(live.shown[e].x);
    out.add_shown_at(live.shown[e].y);
  }
}

// `part`: the record's Header or Footer. `sum`: of what its checksum is about besides itself.
template <typename Part>
std::vector<std::byte> with_checksum(file::Record& record, Part& part, Hasher sum) {
  part.set_checksum(1);  // any but 0 takes as many bytes
  add_up_to_checksum(sum, delimited(record));
  part.set_checksum(checksum_of(sum));
  return delimited(record);
}

}  // namespace

void TraceWriter::hand_over(const file::Record& record) {
  const std::vector<std::byte> bytes = delimited(record);
  add_record(since_checksum_, bytes);
  sink_(bytes);
}

TraceWriter::TraceWriter(const Header& header, ByteSink sink) : sink_(std::move(sink)) {
  const auto entities = static_cast<std::size_t>(header.entities());
  states_.assign(entities, kUntold);
  truth_ = nothing_agreed(entities);
  std::vector<std::byte> start;
  for (const char c : kMagic) start.push_back(static_cast<std::byte>(c));
  start.push_back(static_cast<std::byte>(kFormatVersion));
  sink_(start);
  file::Record record;
  put_header(header, *record.mutable_header());
  sink_(with_checksum(record, *record.mutable_header(), {}));
}

void TraceWriter::begin(const Begin& b) {
  file::Record record;
  file::Begin& out = *record.mutable_begin();
  out.set_tick(static_cast<std::uint32_t>(b.tick));
  out.set_confirmed(static_cast<std::uint32_t>(b.confirmed));
  out.set_transfer(b.transfer.data(), b.transfer.size());
  hand_over(record);
}

void TraceWriter::order(const Order& o) {
  file::Record record;
  record.mutable_order()->set_fetched(o.fetched.data(), o.fetched.size());
  hand_over(record);
}

void TraceWriter::freeze(const Freeze& f) {
  file::Record record;
  record.mutable_freeze()->set_peer(f.peer);
  record.mutable_freeze()->set_frozen(f.frozen);
  hand_over(record);
}

void TraceWriter::give_up(const GiveUp& g) {
  file::Record record;
  record.mutable_give_up()->set_peer(g.peer);
  hand_over(record);
}

void TraceWriter::relayed(const Relayed& r) {
  file::Record record;
  record.mutable_relayed()->set_fetched(r.fetched.data(), r.fetched.size());
  hand_over(record);
}

void TraceWriter::excuse() {
  file::Record record;
  record.mutable_excuse();
  hand_over(record);
}

void TraceWriter::retune(const Retune& r) {
  file::Record record;
  put_technique(r.technique, *record.mutable_retune());
  hand_over(record);
}

void TraceWriter::push(const Push& p) {
  file::Record record;
  record.mutable_push()->set_body(p.body);
  record.mutable_push()->set_x(p.velocity.x);
  record.mutable_push()->set_y(p.velocity.y);
  hand_over(record);
}

void TraceWriter::remark(const Remark& r) {
  file::Record record;
  record.mutable_remark()->set_kind(r.kind);
  record.mutable_remark()->set_peer(r.peer == kNoPeer ? 0U : r.peer + 1U);
  record.mutable_remark()->set_text(r.text);
  hand_over(record);
}

void TraceWriter::step(const Step& s, const LiveView& live) {
  assert(live.states.size() == states_.size() && live.shown.size() == states_.size());
  file::Record record;
  file::Step& out = *record.mutable_step();
  out.set_tick(static_cast<std::uint32_t>(s.tick));
  out.set_target_x(s.target.x);
  out.set_target_y(s.target.y);
  out.set_leaving(s.leaving);
  out.set_outside(s.outside);
  out.set_live_hash(s.live_hash);
  out.set_threshold(s.threshold);
  out.set_own_error(s.own_error);
  out.set_lateness_us(s.lateness);
  out.set_replayed_steps(s.replayed_steps);
  out.set_snaps(s.snaps);
  out.set_snap_m(s.snap_m);
  if (s.signature) out.set_signature(s.signature->data(), s.signature->size());
  put_changes(live.states, states_, out);
  put_shown(live, out);
  out.set_checksum(checksum_of(std::exchange(since_checksum_, {})));
  hand_over(record);
}

void TraceWriter::received(Micros at, std::span<const std::byte> datagram) {
  file::Record record;
  record.mutable_received()->set_at_us(at);
  record.mutable_received()->set_datagram(datagram.data(), datagram.size());
  hand_over(record);
}

void TraceWriter::sent(PeerId to, Tick tick, std::span<const std::byte> datagram) {
  file::Record record;
  record.mutable_sent()->set_to(to);
  record.mutable_sent()->set_tick(static_cast<std::uint32_t>(tick));
  record.mutable_sent()->set_datagram(datagram.data(), datagram.size());
  hand_over(record);
}

void TraceWriter::confirmed(Tick tick, std::uint64_t hash, const Truth& truth) {
  assert(truth.owner.size() == truth_.owner.size());
  file::Record record;
  file::Confirmed& out = *record.mutable_confirmed();
  out.set_tick(static_cast<std::uint32_t>(tick));
  out.set_hash(hash);
  Gaps gaps;
  for (std::size_t e = 0; e < truth.owner.size(); ++e) {
    if (truth.owner[e] == truth_.owner[e] && truth.present[e] == truth_.present[e] &&
        truth.agreed[e] == truth_.agreed[e])
      continue;
    out.add_changed(gaps.next(e));
    out.add_owner(put_owner(truth.owner[e], truth.present[e]));
    out.add_position(truth.agreed[e].x);
    out.add_position(truth.agreed[e].y);
  }
  truth_ = truth;
  hand_over(record);
}

void TraceWriter::footer(const Footer& f) {
  file::Record record;
  file::Footer& out = *record.mutable_footer();
  out.set_bundles(f.bundles);
  for (const std::uint64_t n : f.updates_by_cause) out.add_updates_by_cause(n);
  out.set_repeats(f.repeats);
  out.set_datagrams_sent(f.datagrams_sent);
  out.set_wire_bytes_sent(f.wire_bytes_sent);
  out.set_datagrams_received(f.datagrams_received);
  for (const std::uint64_t n : f.dropped) out.add_dropped(n);
  out.set_hash_checks(f.hash_checks);
  out.set_hash_mismatches(f.hash_mismatches);
  out.set_first_mismatch(f.first_mismatch);
  out.set_superseded(f.superseded);
  for (const Dropped& d : f.dropped_of) {
    file::Dropped& of = *out.add_dropped_of();
    of.set_peer(d.peer);
    for (const std::uint64_t n : d.by_reason) of.add_by_reason(n);
  }
  sink_(with_checksum(record, out, since_checksum_));
}

}  // namespace padr::trace
