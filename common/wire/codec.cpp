#include "common/wire/codec.h"

#include <algorithm>
#include <array>
#include <limits>

#include "common/wire/endpoint_codec.h"
#include "common/wire/update_codec.h"
#include "common/wire/value_column.h"
#include "proto/wire.pb.h"

namespace padr::wire {

using sync::Bundle;
using sync::StatePacket;

namespace {

/// The numbers that every datagram has, in the order of their column.
constexpr int kLinkNumbers = 9;

void put_link(const StatePacket& p, State& out) {
  const std::array<std::uint32_t, kLinkNumbers> numbers{p.seq,           static_cast<std::uint32_t>(p.mark_tick),
                                                        p.mark_count,    p.have,
                                                        p.seen_seq,      p.seen_age,
                                                        p.have_beyond,   p.incarnation,
                                                        p.to_incarnation};
  auto end = numbers.end();
  while (end != numbers.begin() && end[-1] == 0) --end;
  for (auto n = numbers.begin(); n != end; ++n) out.add_link(*n);
}

bool take_link(const State& in, StatePacket& p) {
  if (in.link_size() > kLinkNumbers) return false;
  std::array<std::uint32_t, kLinkNumbers> numbers{};
  std::copy(in.link().begin(), in.link().end(), numbers.begin());
  constexpr auto kMaxTick = static_cast<std::uint32_t>(std::numeric_limits<Tick>::max());
  if (numbers[0] == 0 || numbers[1] >= kMaxTick) return false;
  p.seq = numbers[0];
  p.mark_tick = static_cast<Tick>(numbers[1]);
  p.mark_count = numbers[2];
  p.have = numbers[3];
  p.seen_seq = numbers[4];
  p.seen_age = numbers[5];
  p.have_beyond = numbers[6];
  p.incarnation = numbers[7];
  p.to_incarnation = numbers[8];
  return true;
}

}  // namespace

StateEncoder::StateEncoder() : message_(std::make_unique<State>()) {}
StateEncoder::~StateEncoder() = default;
StateEncoder::StateEncoder(StateEncoder&&) noexcept = default;

std::span<const std::byte> StateEncoder::encode(const StatePacket& p) {
  State& out = *message_;
  out.Clear();
  put_link(p, out);
  out.set_transit(p.transit);
  out.set_loss(p.loss);
  for (const Bundle& b : p.updates) put_update(b, p.mark_tick, p.mark_count, *out.add_updates());
  if (p.check_tick >= 0) {
    out.set_check_age(static_cast<std::uint32_t>(p.mark_tick - p.check_tick));
    out.set_check_hash(p.check_hash);
  }
  bytes_.resize(out.ByteSizeLong());
  out.SerializeToArray(bytes_.data(), static_cast<int>(bytes_.size()));
  return bytes_;
}

StateDecoder::StateDecoder() : message_(std::make_unique<State>()) {}
StateDecoder::~StateDecoder() = default;
StateDecoder::StateDecoder(StateDecoder&&) noexcept = default;

const StatePacket* StateDecoder::decode(std::span<const std::byte> payload, PeerId sender) {
  if (!message_->ParseFromArray(payload.data(), static_cast<int>(payload.size()))) return nullptr;
  return take(sender) ? &packet_ : nullptr;
}

bool StateDecoder::take(PeerId sender) {
  const State& in = *message_;
  StatePacket& p = packet_;
  if (!take_link(in, p) || in.loss() > 100 || in.check_age() > static_cast<std::uint32_t>(p.mark_tick)) return false;
  p.transit = in.transit();
  p.loss = in.loss();
  const auto n = static_cast<std::size_t>(in.updates_size());
  for (; p.updates.size() > n; p.updates.pop_back()) spare_.push_back(std::move(p.updates.back()));
  for (; p.updates.size() < n && !spare_.empty(); spare_.pop_back()) p.updates.push_back(std::move(spare_.back()));
  p.updates.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    p.updates[i].peer = sender;
    if (!take_update(in.updates(static_cast<int>(i)), p.mark_tick, p.mark_count, p.updates[i])) return false;
  }
  p.check_tick = in.check_hash() != 0 ? p.mark_tick - static_cast<Tick>(in.check_age()) : -1;
  p.check_hash = in.check_hash();
  return true;
}

Bytes encode(const StatePacket& p) {
  StateEncoder encoder;
  const auto bytes = encoder.encode(p);
  return {bytes.begin(), bytes.end()};
}

std::optional<StatePacket> decode_state(std::span<const std::byte> payload, PeerId sender) {
  StateDecoder decoder;
  const StatePacket* p = decoder.decode(payload, sender);
  return p == nullptr ? std::nullopt : std::optional(*p);
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
         number(a.at.port) + with_length(have) + (a.spectator ? number(1) : 0);
}

/// Of the column that its values are told in.
template <typename States>
std::size_t size_of_values(const States& of) {
  std::size_t in_all = 0;
  const bool steps = all_in_steps(of);
  each_value(of, [&](float v, float step) {
    const auto n = steps ? static_cast<std::uint32_t>(to_steps(v, step)) : 0;
    in_all += steps ? varint(n << 1U ^ (n >> 31U == 0 ? 0 : ~0U)) : sizeof(float);
  });
  return with_length(in_all);
}

std::size_t size_of_entities(const Bundle& b) {
  std::size_t numbers = 0;
  unsigned next = 0;
  for (const sync::BodyUpdate& u : b.bodies) {
    numbers += varint((u.body - next) << 7U | 0x7FU);
    next = u.body + 1U;
    if (!u.has_state) continue;
    numbers += varint(u.epoch) + varint(static_cast<std::uint32_t>(b.tick - u.claimed));
  }
  return (b.avatar ? number(0) : 0) + with_length(numbers) + size_of_values(b);
}

std::size_t size_of(const sync::Passage& p) {
  constexpr std::uint32_t kMostFlags = 0xFFFF;
  const std::size_t state = p.kind == sync::Passage::Kind::kIn ? size_of_values(p.state) : 0;
  return number(p.name.region) + number(p.name.number) + number(p.crossings) + number(p.to) + number(kMostFlags) +
         state;
}

/// Of everything in the update's message but what counts back from the mark.
std::size_t size_of(const Bundle& b) {
  std::size_t n = size_of_entities(b);
  if (b.leave) n += number(1);
  if (b.going) n += 1 + number(1);  // its key has two bytes
  if (b.spectates) n += 1 + number(1);
  for (const sync::Passage& p : b.passages) n += with_length(size_of(p));
  if (b.signature) n += with_length(b.signature->size());
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
