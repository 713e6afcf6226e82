#include "common/wire/codec.h"

#include <limits>

#include "common/wire/endpoint_codec.h"
#include "common/wire/update_codec.h"
#include "proto/wire.pb.h"

namespace padr::wire {

using sync::Bundle;
using sync::StatePacket;

Bytes encode(const StatePacket& p) {
  State out;
  out.set_seq(p.seq);
  out.set_mark_tick(static_cast<std::uint32_t>(p.mark_tick));
  out.set_mark_count(p.mark_count);
  out.set_have(p.have);
  out.set_have_beyond(p.have_beyond);
  out.set_seen_seq(p.seen_seq);
  out.set_seen_age(p.seen_age);
  out.set_transit(p.transit);
  out.set_loss(p.loss);
  out.set_incarnation(p.incarnation);
  out.set_to_incarnation(p.to_incarnation);
  for (const Bundle& b : p.updates) put_update(b, p.mark_tick, p.mark_count, *out.add_updates());
  if (p.check_tick >= 0) {
    out.set_check_age(static_cast<std::uint32_t>(p.mark_tick - p.check_tick));
    out.set_check_hash(p.check_hash);
  }
  Bytes bytes(out.ByteSizeLong());
  out.SerializeToArray(bytes.data(), static_cast<int>(bytes.size()));
  return bytes;
}

std::optional<StatePacket> decode_state(std::span<const std::byte> payload, PeerId sender) {
  State in;
  if (!in.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) return std::nullopt;
  constexpr auto kMaxTick = static_cast<std::uint32_t>(std::numeric_limits<Tick>::max());
  if (in.mark_tick() >= kMaxTick || in.check_age() > in.mark_tick() || in.seq() == 0 || in.loss() > 100)
    return std::nullopt;
  StatePacket p;
  p.seq = in.seq();
  p.mark_tick = static_cast<Tick>(in.mark_tick());
  p.mark_count = in.mark_count();
  p.have = in.have();
  p.have_beyond = in.have_beyond();
  p.seen_seq = in.seen_seq();
  p.seen_age = in.seen_age();
  p.transit = in.transit();
  p.loss = in.loss();
  p.incarnation = in.incarnation();
  p.to_incarnation = in.to_incarnation();
  for (const Update& u : in.updates()) {
    Bundle b;
    b.peer = sender;
    if (!take_update(u, p.mark_tick, p.mark_count, b)) return std::nullopt;
    p.updates.push_back(std::move(b));
  }
  if (in.check_hash() != 0) {
    p.check_tick = p.mark_tick - static_cast<Tick>(in.check_age());
    p.check_hash = in.check_hash();
  }
  return p;
}

namespace {

std::size_t varint(std::uint32_t v) {
  std::size_t n = 1;
  for (; v >= 0x80; v >>= 7U) ++n;
  return n;
}

/// A number with its key; a 0 is not written, but may be counted.
std::size_t number(std::uint32_t v) {
  return 1 + varint(v);
}

/// So many bytes with their key and length; none are not written.
std::size_t with_length(std::size_t bytes) {
  return bytes == 0 ? 0 : number(static_cast<std::uint32_t>(bytes)) + bytes;
}

std::size_t size_of(const sync::Admission& a) {
  std::size_t have = 0;
  for (const std::uint32_t count : a.have) have += varint(count);
  return number(a.slot) + number(a.incarnation) + number(a.first) + with_length(address_bytes(a.at).size()) +
         number(a.at.port) + with_length(have);
}

std::size_t size_of(const std::vector<sync::BodyUpdate>& bodies, Tick tick) {
  std::size_t ids = 0;
  std::size_t epochs = 0;
  std::size_t ages = 0;
  std::size_t floats = 0;
  for (const sync::BodyUpdate& u : bodies) {
    ids += varint(u.body);
    if (!u.has_state) continue;
    epochs += varint(u.epoch);
    ages += varint(static_cast<std::uint32_t>(tick - u.claimed));
    floats += u.state.awake ? 6 : 3;
  }
  return with_length(ids) + with_length(bodies.size()) + with_length(epochs) + with_length(ages) +
         with_length(floats * sizeof(float));
}

/// Of everything in the update's message but what counts back from the mark.
std::size_t size_of(const Bundle& b) {
  std::size_t n = size_of(b.bodies, b.tick);
  if (b.leave) n += number(1);
  if (b.signature) n += with_length(b.signature->size());
  if (b.avatar) n += number(0) + with_length(6 * sizeof(float));
  if (b.admission) n += with_length(size_of(*b.admission));
  for (const sync::Removal& r : b.removals) n += with_length(number(r.slot) + number(r.incarnation) + number(r.count));
  for (const Bundle& lost : b.passed_on)
    n += with_length(number(lost.peer) + number(lost.index) + number(static_cast<std::uint32_t>(lost.tick)) +
                     with_length(size_of(lost)));
  return n;
}

}  // namespace

std::size_t encoded_size(const Bundle& b) {
  // How far the mark is ahead is not known yet: three bytes do for two million.
  constexpr std::size_t kBack = 2 * (1 + 3);
  const std::size_t n = kBack + size_of(b);
  return with_length(n);
}

}  // namespace padr::wire
