// What the tests of the delivery share.
#pragma once

#include <cstdint>
#include <optional>

#include "common/delivery/delivery.h"

namespace padr::test {

inline std::size_t forty(const sync::Bundle&) {
  return 40;
}

/// One link to script: what we have said so far and when.
struct Script {
  sync::OutLink link;
  Ring<sync::Bundle> own;
  std::size_t bytes = 1;  ///< of each datagram
  void update(Tick t) {
    sync::Bundle b;
    b.index = static_cast<std::uint32_t>(own.size());
    b.tick = t;
    own.push_back(b);
  }
  std::optional<sync::StatePacket> at(Tick t, bool gap = false, std::size_t room = 1000) {
    const sync::StatePacket* p = send({t, 0, 0, gap}, room);
    return p == nullptr ? std::nullopt : std::optional(*p);
  }
  /// What goes out, if anything does; on a link wide enough for all of it.
  const sync::StatePacket* send(const sync::OutLink::Context& c, std::size_t room = 1000) {
    const sync::StatePacket* p = link.compose(c, own, 0, forty, room);
    if (p != nullptr) link.left(bytes, c.now);
    return p;
  }
  /// Whether the first update goes out then, after another one if `news`.
  bool tells_first(Tick t, bool news) {
    if (news) update(t);
    const auto p = at(t, false, 100'000);
    return p && !p->updates.empty() && p->updates.front().index == 0;
  }
  void loses(std::uint32_t per_cent) {
    sync::StatePacket p;
    p.seq = 1;
    p.loss = per_cent;
    link.on_packet(p, 0);
  }
  /// What has been sent by then has arrived, and the word of that here.
  void answers(Tick t) {
    if (t % 10 != 0) return;
    sync::StatePacket p;
    p.seq = ++answers_;
    p.updates.resize(1);
    p.have = link.acked();
    p.seen_seq = link.sent();
    link.on_packet(p, t);
  }
  std::uint32_t answers_ = 1000;
  void hear(Tick t, std::uint32_t seq, std::uint32_t have, std::uint32_t seen, std::uint32_t age = 0,
            std::uint32_t beyond = 0) {
    sync::StatePacket p;
    p.seq = seq + 1;
    p.mark_tick = t;
    p.updates.resize(1);  // marks alone tell of loss
    p.have = have;
    p.seen_seq = seen;
    p.seen_age = age;
    p.have_beyond = beyond;
    link.on_packet(p, t);
  }
  /// What goes out next is answered so long after it left.
  void answered_after(Tick ticks, Tick& t) {
    while (!at(t)) ++t;
    const std::uint32_t seq = link.sent();
    t += ticks;
    hear(t, seq, link.acked(), seq);
  }
};

}  // namespace padr::test
