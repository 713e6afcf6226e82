#include "tests/monitor/samples.h"

#include <string>

namespace padr::test {
namespace {

std::string any_text(Rng& rng, std::uint32_t most) {
  std::string s;
  for (std::uint32_t n = rng.below(most + 1); n > 0; --n) s += static_cast<char>(rng.below(256));
  return s;
}

Endpoint any_endpoint(Rng& rng) {
  Endpoint e;
  for (auto& byte : e.address) byte = static_cast<std::uint8_t>(1 + rng.below(255));
  e.port = static_cast<std::uint16_t>(1 + rng.below(65535));
  return e;
}

PeerId any_slot(Rng& rng) {
  const std::uint32_t p = rng.below(kMaxPeers + 1);
  return p == kMaxPeers ? kNoPeer : static_cast<PeerId>(p);
}

float whole(Rng& rng, int most) {
  const auto range = static_cast<std::uint32_t>(2 * most + 1);
  return static_cast<float>(static_cast<double>(static_cast<int>(rng.below(range)) - most) * 1e-3);
}

monitor::Place any_place(Rng& rng) {
  const int angle = static_cast<int>(rng.below(6283)) - 3141;
  return {{whole(rng, 8'000'000), whole(rng, 40'000)}, static_cast<float>(angle) * 1e-3F};
}

monitor::Place near(Rng& rng, const monitor::Place& p) {
  return rng.chance(0.7) ? p : any_place(rng);
}

monitor::EntityFlags any_flags(Rng& rng) {
  return {rng.chance(0.9), rng.chance(0.5), rng.chance(0.1), any_slot(rng)};
}

monitor::Hello any_hello(Rng& rng) {
  monitor::Hello h;
  h.version = any_text(rng, 100);
  h.control = rng.chance(0.5);
  h.token = rng.next_u64();
  if (rng.chance(0.8)) h.at = any_endpoint(rng);
  h.slots = static_cast<int>(rng.below(kMaxPeers + 1));
  h.incarnation = static_cast<int>(rng.below(10));
  h.scenario = any_text(rng, 100);
  h.scenario_seed = rng.next_u64();
  h.scene_hash = rng.next_u64();
  h.scenario_bytes = rng.below(100'000);
  h.technique = any_text(rng, 400);
  h.netem = any_text(rng, 100);
  h.input = any_text(rng, 100);
  h.rate = static_cast<int>(rng.below(61));
  h.detail = static_cast<monitor::Detail>(rng.below(3));
  return h;
}

monitor::ScenarioPart any_part(Rng& rng) {
  monitor::ScenarioPart s;
  s.scene_hash = rng.next_u64();
  s.text = any_text(rng, 1000);
  s.offset = rng.below(50'000);
  s.total = s.offset + static_cast<std::uint32_t>(s.text.size()) + rng.below(1000);
  return s;
}

monitor::Agreed any_agreed(Rng& rng) {
  monitor::Agreed a;
  a.tick = static_cast<Tick>(rng.below(1'000'000));
  a.hash = rng.next_u64();
  a.total = static_cast<EntityId>(rng.below(30));
  for (EntityId e = 0; e < a.total; ++e) {
    a.flags.push_back(any_flags(rng));
    a.at.push_back(any_place(rng));
  }
  return a;
}

monitor::LinkStatus any_link(Rng& rng) {
  monitor::LinkStatus l;
  l.to = any_slot(rng);
  l.incarnation = rng.next_u32();
  l.there = rng.chance(0.8);
  if (rng.chance(0.9)) l.at = any_endpoint(rng);
  l.round_trip_ms = static_cast<float>(rng.uniform(0, 500));
  l.measured = rng.chance(0.9);
  for (float* ms : {&l.delay_least_ms, &l.delay_p50_ms, &l.delay_p95_ms})
    *ms = static_cast<float>(rng.uniform(-500, 500));
  l.loss_in = static_cast<float>(rng.uniform());
  l.loss_of = static_cast<std::uint32_t>(rng.below(193));
  l.judged_in = rng.next_u64() >> (1 + rng.below(63));
  l.lost_in = rng.next_u64() % (l.judged_in + 1);
  l.silence_ms = static_cast<float>(rng.uniform(0, 5000));
  l.carries_kbit_s = static_cast<float>(rng.uniform(0, 100));
  l.queue_ms = static_cast<float>(rng.uniform(0, 3000));
  l.carrier = rng.below(2) == 0 ? kNoPeer : static_cast<PeerId>(rng.below(8));
  l.cut_out = rng.chance(0.1);
  l.cut_in = rng.chance(0.1);
  l.netem = any_text(rng, 60);
  if (rng.chance(0.3)) l.dropped[rng.below(sync::kDropReasons)] = rng.next_u64() >> rng.below(64);
  if (rng.chance(0.1)) l.cut_offs = rng.next_u32();
  return l;
}

monitor::Status any_status(Rng& rng) {
  monitor::Status s;
  s.tick = static_cast<Tick>(rng.below(1'000'000));
  for (auto& n : s.updates_by_cause) n = rng.next_u64() >> rng.below(64);
  for (std::uint64_t* n : {&s.datagrams_sent, &s.bytes_sent, &s.repeats, &s.datagrams_received, &s.dropped, &s.hash,
                           &s.hash_checks, &s.hash_mismatches, &s.replayed_steps, &s.steps, &s.late_ticks, &s.untold})
    *n = rng.next_u64() >> rng.below(64);
  s.confirmed = static_cast<Tick>(rng.below(1000)) - 1;
  s.worst_late_us = static_cast<std::int64_t>(rng.below(1'000'000)) - 500'000;
  s.clock_lead_us = static_cast<std::int64_t>(rng.below(1'000'000)) - 500'000;
  s.own_error_m = static_cast<float>(rng.uniform(0, 10));
  s.price = static_cast<float>(rng.uniform(1, 27));
  s.snaps = rng.next_u32();
  s.snap_m = rng.uniform(0, 100);
  s.present = static_cast<int>(rng.below(kMaxPeers + 1));
  s.paused = rng.chance(0.1);
  for (std::uint32_t n = rng.below(6); n > 0; --n) s.links.push_back(any_link(rng));
  return s;
}

monitor::Events any_events(Rng& rng) {
  monitor::Events all;
  std::uint32_t number = 0;
  for (std::uint32_t n = rng.below(9); n > 0; --n) {
    monitor::Event e;
    e.number = number += 1 + rng.below(3);
    e.tick = static_cast<Tick>(rng.below(1'000'000));
    e.kind = static_cast<monitor::EventKind>(rng.below(monitor::kEventKinds));
    e.entity = rng.chance(0.3) ? kNoEntity : static_cast<EntityId>(rng.below(60'000));
    e.peer = any_slot(rng);
    e.order = rng.below(4);
    e.text = any_text(rng, 80);
    all.events.push_back(e);
  }
  return all;
}

float any_metres(Rng& rng, double most) {
  return static_cast<float>(rng.uniform(-most, most));
}

}  // namespace

monitor::Origin any_origin(Rng& rng) {
  return {rng.next_u64(), static_cast<std::uint16_t>(rng.below(65536)), any_slot(rng), rng.next_u32()};
}

monitor::Frame any_frame(Rng& rng, EntityId entities, int views) {
  monitor::Frame f;
  f.tick = static_cast<Tick>(rng.below(1'000'000));
  f.threshold = static_cast<float>(rng.uniform(0, 100));
  f.target = any_place(rng).position;
  f.driven = rng.chance(0.5);
  f.holding = rng.chance(0.5);
  f.interaction = rng.chance(0.5);
  f.unowned_alone = rng.chance(0.5);
  f.contact_in = static_cast<Tick>(rng.below(32)) - 1;
  f.level = static_cast<float>(rng.uniform());
  f.radius = static_cast<float>(rng.uniform(0, 100));
  f.total = entities;
  for (EntityId e = 0; e < entities; ++e) {
    f.flags.push_back(any_flags(rng));
    f.shown.push_back(any_place(rng));
    if (views > 1) f.live.push_back(near(rng, f.shown.back()));
    if (views > 2) f.predicted.push_back(near(rng, f.live.back()));
  }
  return f;
}

monitor::Message any_message(Rng& rng, std::uint32_t kind) {
  switch (kind) {
    case 0:
      return any_hello(rng);
    case 1:
      return any_part(rng);
    case 2:
      return any_frame(rng, static_cast<EntityId>(rng.below(20)), static_cast<int>(1 + rng.below(3)));
    case 3:
      return any_agreed(rng);
    case 4:
      return any_status(rng);
    default:
      return any_events(rng);
  }
}

monitor::Order any_order(Rng& rng) {
  monitor::Order o;
  o.process = rng.next_u64();
  o.token = rng.next_u64();
  o.issuer = rng.next_u64() | 1U;
  o.number = 1 + rng.below(1000);
  switch (rng.below(6)) {
    case 0: {
      const auto kind = static_cast<monitor::Drive::Kind>(rng.below(3));
      const double most = kind == monitor::Drive::Kind::kDirection ? 1 : 1e6;
      o.what = monitor::Drive{kind, {any_metres(rng, most), any_metres(rng, most)}};
      break;
    }
    case 1:
      o.what = monitor::Knob{any_text(rng, 40), any_text(rng, 40)};
      break;
    case 2:
      o.what = monitor::Netem{any_slot(rng), any_text(rng, 200)};
      break;
    case 3:
      o.what = monitor::Cut{any_slot(rng), static_cast<float>(rng.uniform(0, 600)),
                            static_cast<monitor::Ways>(rng.below(3))};
      break;
    case 4:
      o.what = monitor::Pause{static_cast<float>(rng.uniform(0, 600))};
      break;
    default:
      o.what = monitor::Push{static_cast<EntityId>(rng.below(60'000)), {any_metres(rng, 40), any_metres(rng, 40)}};
  }
  return o;
}

}  // namespace padr::test
