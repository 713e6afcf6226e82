#include <cassert>

#include "common/monitor/format.h"
#include "common/monitor/world_codec.h"
#include "common/wire/endpoint_codec.h"

namespace padr::monitor {
namespace {

constexpr std::uint32_t kThere = 1;
constexpr std::uint32_t kMeasured = 2;
constexpr std::uint32_t kCutOut = 4;
constexpr std::uint32_t kCutIn = 8;

constexpr float kMostMs = 1.0e9F;
constexpr float kMostKbit = 1.0e6F;
constexpr float kMostPrice = 1.0e6F;
constexpr int kMostRate = 60;  // 1/s

bool take_address(const file::Address& in, Endpoint& at) {
  return in.address().empty() ? in.port() == 0 : wire::take_endpoint(in, at);
}

void put_origin(const Origin& o, file::Origin& out) {
  out.set_process(o.process);
  out.set_session(o.session);
  out.set_slot(put_slot(o.slot));
  out.set_incarnation(o.incarnation);
}

bool take_origin(const file::Origin& in, Origin& o) {
  o.process = in.process();
  o.session = static_cast<std::uint16_t>(in.session());
  o.incarnation = in.incarnation();
  return in.session() <= 0xFFFF && take_slot(in.slot(), o.slot);
}

void put(const Hello& h, file::Hello& out) {
  constexpr std::size_t kEach = 120;  // users write as much as they like, and the technique takes most of the room
  out.set_version(h.version.substr(0, kEach));
  out.set_control(h.control);
  out.set_token(h.token);
  if (h.at.is_set()) wire::put_endpoint(h.at, *out.mutable_at());
  out.set_slots(static_cast<std::uint32_t>(h.slots));
  out.set_life(static_cast<std::uint32_t>(h.incarnation));
  out.set_scenario_seed(h.scenario_seed);
  out.set_scene_hash(h.scene_hash);
  out.set_scenario_bytes(h.scenario_bytes);
  out.set_technique(cut_text(h.technique));
  out.set_rate(static_cast<std::uint32_t>(h.rate));
  out.set_detail(static_cast<std::uint32_t>(h.detail));

  out.set_scenario(h.scenario.substr(0, kEach));
  out.set_netem(h.netem.substr(0, kEach));
  out.set_input(h.input.substr(0, kEach));
}

bool take(const file::Hello& in, Hello& h) {
  if (in.slots() > static_cast<std::uint32_t>(kMaxPeers) || in.life() > 1'000'000 ||
      in.scenario_bytes() > kMostScenario || in.rate() > static_cast<std::uint32_t>(kMostRate) ||
      in.detail() > static_cast<std::uint32_t>(Detail::kAll))
    return false;
  h.control = in.control();
  h.token = in.token();
  h.slots = static_cast<int>(in.slots());
  h.incarnation = static_cast<int>(in.life());
  h.scenario_seed = in.scenario_seed();
  h.scene_hash = in.scene_hash();
  h.scenario_bytes = in.scenario_bytes();
  h.rate = static_cast<int>(in.rate());
  h.detail = static_cast<Detail>(in.detail());
  return take_address(in.at(), h.at) && take_text(in.version(), h.version) && take_text(in.scenario(), h.scenario) &&
         take_text(in.technique(), h.technique) && take_text(in.netem(), h.netem) && take_text(in.input(), h.input);
}

void put(const ScenarioPart& s, file::ScenarioPart& out) {
  assert(s.text.size() <= kMostPart);
  out.set_scene_hash(s.scene_hash);
  out.set_total(s.total);
  out.set_offset(s.offset);
  out.set_text(s.text);
}

bool take(const file::ScenarioPart& in, ScenarioPart& s) {
  if (in.total() > kMostScenario || in.offset() > in.total() || in.text().size() > in.total() - in.offset() ||
      in.text().size() > kMostPart)
    return false;
  s.scene_hash = in.scene_hash();
  s.total = in.total();
  s.offset = in.offset();
  s.text = in.text();
  return true;
}

void put(const LinkStatus& l, file::Link& out) {
  out.set_to(put_slot(l.to));
  out.set_incarnation(l.incarnation);
  out.set_flags((l.there ? kThere : 0) | (l.measured ? kMeasured : 0) | (l.cut_out ? kCutOut : 0) |
                (l.cut_in ? kCutIn : 0));
  if (l.at.is_set()) wire::put_endpoint(l.at, *out.mutable_at());
  out.set_round_trip_ms(l.round_trip_ms);
  out.set_delay_least_ms(l.delay_least_ms);
  out.set_delay_p50_ms(l.delay_p50_ms);
  out.set_delay_p95_ms(l.delay_p95_ms);
  out.set_loss_in(l.loss_in);
  out.set_loss_of(l.loss_of);
  out.set_lost_in(l.lost_in);
  out.set_judged_in(l.judged_in);
  out.set_silence_ms(l.silence_ms);
  out.set_carries_kbit_s(l.carries_kbit_s);
  out.set_queue_ms(l.queue_ms);
  out.set_carrier(put_slot(l.carrier));
  out.set_netem(cut_text(l.netem));
  // Mostly there is nothing to tell, and a datagram has room for more links then.
  const auto last = std::find_if(l.dropped.rbegin(), l.dropped.rend(), [](std::uint64_t n) { return n > 0; });
  out.mutable_dropped()->Assign(l.dropped.begin(), last.base());
  out.set_cut_offs(l.cut_offs);
}

bool take(const file::Link& in, LinkStatus& l) {
  if (in.flags() > (kThere | kMeasured | kCutOut | kCutIn) ||
      static_cast<std::size_t>(in.dropped_size()) > sync::kDropReasons)
    return false;
  std::copy(in.dropped().begin(), in.dropped().end(), l.dropped.begin());
  l.cut_offs = in.cut_offs();
  l.loss_of = in.loss_of();
  l.lost_in = in.lost_in();
  l.judged_in = in.judged_in();
  if (l.lost_in > l.judged_in) return false;
  l.incarnation = in.incarnation();
  l.there = (in.flags() & kThere) != 0;
  l.measured = (in.flags() & kMeasured) != 0;
  l.cut_out = (in.flags() & kCutOut) != 0;
  l.cut_in = (in.flags() & kCutIn) != 0;
  return take_slot(in.to(), l.to) && take_address(in.at(), l.at) &&
         take_between(in.round_trip_ms(), 0, kMostMs, l.round_trip_ms) &&
         take_between(in.delay_least_ms(), -kMostMs, kMostMs, l.delay_least_ms) &&
         take_between(in.delay_p50_ms(), -kMostMs, kMostMs, l.delay_p50_ms) &&
         take_between(in.delay_p95_ms(), -kMostMs, kMostMs, l.delay_p95_ms) &&
         take_between(in.loss_in(), 0, 1, l.loss_in) && take_between(in.silence_ms(), 0, kMostMs, l.silence_ms) &&
         take_between(in.carries_kbit_s(), 0, kMostKbit, l.carries_kbit_s) &&
         take_between(in.queue_ms(), 0, kMostMs, l.queue_ms) && take_slot(in.carrier(), l.carrier) &&
         take_text(in.netem(), l.netem);
}

void put(const Status& s, file::Status& out) {
  out.set_tick(static_cast<std::uint32_t>(s.tick));
  for (const std::uint64_t n : s.updates_by_cause) out.add_updates_by_cause(n);
  out.set_datagrams_sent(s.datagrams_sent);
  out.set_bytes_sent(s.bytes_sent);
  out.set_repeats(s.repeats);
  out.set_datagrams_received(s.datagrams_received);
  out.set_dropped(s.dropped);
  out.set_confirmed(s.confirmed);
  out.set_hash(s.hash);
  out.set_hash_checks(s.hash_checks);
  out.set_hash_mismatches(s.hash_mismatches);
  out.set_replayed_steps(s.replayed_steps);
  out.set_steps(s.steps);
  out.set_late_ticks(s.late_ticks);
  out.set_worst_late_us(s.worst_late_us);
  out.set_clock_lead_us(s.clock_lead_us);
  out.set_own_error_m(s.own_error_m);
  out.set_price(s.price);
  out.set_snaps(s.snaps);
  out.set_snap_m(s.snap_m);
  out.set_present(static_cast<std::uint32_t>(s.present));
  out.set_paused(s.paused);
  out.set_untold(s.untold);
}

bool take(const file::Status& in, Status& s) {
  if (static_cast<std::size_t>(in.updates_by_cause_size()) != sync::kCauses || in.links_size() > kMaxPeers ||
      in.confirmed() < -1 || in.present() > static_cast<std::uint32_t>(kMaxPeers) || !std::isfinite(in.snap_m()))
    return false;
  std::copy(in.updates_by_cause().begin(), in.updates_by_cause().end(), s.updates_by_cause.begin());
  s.datagrams_sent = in.datagrams_sent();
  s.bytes_sent = in.bytes_sent();
  s.repeats = in.repeats();
  s.datagrams_received = in.datagrams_received();
  s.dropped = in.dropped();
  s.confirmed = in.confirmed();
  s.hash = in.hash();
  s.hash_checks = in.hash_checks();
  s.hash_mismatches = in.hash_mismatches();
  s.replayed_steps = in.replayed_steps();
  s.steps = in.steps();
  s.late_ticks = in.late_ticks();
  s.worst_late_us = in.worst_late_us();
  s.clock_lead_us = in.clock_lead_us();
  s.snaps = in.snaps();
  s.snap_m = in.snap_m();
  s.present = static_cast<int>(in.present());
  s.paused = in.paused();
  s.untold = in.untold();
  for (const file::Link& l : in.links())
    if (!take(l, s.links.emplace_back())) return false;
  return take_tick(in.tick(), s.tick) && take_between(in.own_error_m(), 0, kMostMetres, s.own_error_m) &&
         take_between(in.price(), 0, kMostPrice, s.price);
}

void put(const Event& e, file::Event& out) {
  out.set_number(e.number);
  out.set_tick(static_cast<std::uint32_t>(e.tick));
  out.set_kind(static_cast<std::uint32_t>(e.kind));
  out.set_entity(e.entity == kNoEntity ? 0U : e.entity + 1U);
  out.set_peer(put_slot(e.peer));
  out.set_order(e.order);
  out.set_text(cut_text(e.text));
}

bool take(const file::Event& in, Event& e) {
  if (in.number() == 0 || in.kind() >= kEventKinds || in.entity() > kNoEntity) return false;
  e.number = in.number();
  e.kind = static_cast<EventKind>(in.kind());
  e.entity = in.entity() == 0 ? kNoEntity : static_cast<EntityId>(in.entity() - 1);
  e.order = in.order();
  return take_tick(in.tick(), e.tick) && take_slot(in.peer(), e.peer) && take_text(in.text(), e.text);
}

bool take(const file::Events& in, Events& out) {
  if (static_cast<std::size_t>(in.events_size()) > kMostEvents) return false;
  for (const file::Event& e : in.events()) {
    if (!take(e, out.events.emplace_back())) return false;
    const std::size_t n = out.events.size();
    if (n > 1 && out.events[n - 1].number <= out.events[n - 2].number) return false;
  }
  return true;
}

/// Puts together what one message tells.
class Encoder {
 public:
  explicit Encoder(const Origin& from) { put_origin(from, *datagram_.mutable_origin()); }

  void operator()(const Hello& h) {
    put(h, *datagram_.mutable_hello());
    hand_over();
  }
  void operator()(const ScenarioPart& s) {
    put(s, *datagram_.mutable_scenario());
    hand_over();
  }
  void operator()(const Frame& f) { put_world(datagram_.origin(), f, out); }
  void operator()(const Agreed& a) { put_world(datagram_.origin(), a, out); }
  void operator()(const Status& s) {
    file::Status& status = *datagram_.mutable_status();
    put(s, status);
    for (const LinkStatus& l : s.links) {
      put(l, *status.add_links());
      if (datagram_.ByteSizeLong() <= kRoom) continue;
      status.mutable_links()->RemoveLast();
      hand_over();
      status.mutable_links()->Clear();
      put(l, *status.add_links());
    }
    hand_over();
  }
  // From the newest on, as long as there is room.
  void operator()(const Events& events) {
    file::Events& in = *datagram_.mutable_events();
    const std::size_t most = std::min(events.events.size(), kMostEvents);
    for (std::size_t i = 0; i < most; ++i) {
      put(events.events[events.events.size() - 1 - i], *in.add_events());
      if (datagram_.ByteSizeLong() <= kRoom) continue;
      in.mutable_events()->RemoveLast();
      break;
    }
    std::reverse(in.mutable_events()->begin(), in.mutable_events()->end());
    hand_over();
  }

  std::vector<Bytes> out;

 private:
  void hand_over() { out.push_back(to_bytes(datagram_)); }
  file::Datagram datagram_;
};

template <typename T, typename In>
bool take_as(const In& in, Message& out) {
  return take(in, out.emplace<T>());
}

bool take_message(const file::Datagram& in, Message& out) {
  switch (in.kind_case()) {
    case file::Datagram::kHello:
      return take_as<Hello>(in.hello(), out);
    case file::Datagram::kScenario:
      return take_as<ScenarioPart>(in.scenario(), out);
    case file::Datagram::kFrame:
      return take_world(in.frame(), out.emplace<Frame>());
    case file::Datagram::kAgreed:
      return take_world(in.agreed(), out.emplace<Agreed>());
    case file::Datagram::kStatus:
      return take_as<Status>(in.status(), out);
    case file::Datagram::kEvents:
      return take_as<Events>(in.events(), out);
    case file::Datagram::kOrder:
    case file::Datagram::KIND_NOT_SET:
      break;
  }
  return false;
}

}  // namespace

std::vector<Bytes> encode(const Origin& from, const Message& message) {
  Encoder encoder(from);
  std::visit(encoder, message);
  return std::move(encoder.out);
}

std::optional<Told> decode_told(std::span<const std::byte> datagram) {
  file::Datagram in;
  Told told;
  if (!from_bytes(datagram, in) || !take_origin(in.origin(), told.from) || !take_message(in, told.message))
    return std::nullopt;
  return told;
}

}  // namespace padr::monitor
