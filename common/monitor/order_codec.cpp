#include "common/monitor/format.h"

namespace padr::monitor {
namespace {

struct Put {
  file::Order& out;

  void operator()(const Drive& d) const {
    file::Drive& to = *out.mutable_drive();
    to.set_kind(static_cast<std::uint32_t>(d.kind));
    to.set_x(d.to.x);
    to.set_y(d.to.y);
  }
  void operator()(const Knob& k) const {
    out.mutable_knob()->set_name(cut_text(k.name));
    out.mutable_knob()->set_value(cut_text(k.value));
  }
  void operator()(const Netem& n) const {
    out.mutable_netem()->set_to(put_slot(n.to));
    out.mutable_netem()->set_spec(cut_text(n.spec));
  }
  void operator()(const Cut& c) const {
    out.mutable_cut()->set_peer(put_slot(c.peer));
    out.mutable_cut()->set_ways(static_cast<std::uint32_t>(c.ways));
    out.mutable_cut()->set_seconds(c.seconds);
  }
  void operator()(const Pause& p) const { out.mutable_pause()->set_seconds(p.seconds); }
  void operator()(const Push& p) const {
    out.mutable_push()->set_body(p.body);
    out.mutable_push()->set_x(p.velocity.x);
    out.mutable_push()->set_y(p.velocity.y);
  }
};

bool take_vector(float x, float y, float most, Vec2& out) {
  return take_between(x, -most, most, out.x) && take_between(y, -most, most, out.y);
}

bool take(const file::Drive& in, Drive& d) {
  if (in.kind() > static_cast<std::uint32_t>(Drive::Kind::kDirection)) return false;
  d.kind = static_cast<Drive::Kind>(in.kind());
  return take_vector(in.x(), in.y(), d.kind == Drive::Kind::kDirection ? 1 : kMostMetres, d.to);
}

bool take(const file::Push& in, Push& p) {
  p.body = static_cast<EntityId>(in.body());
  return in.body() < kNoEntity && take_vector(in.x(), in.y(), kMostPush, p.velocity);
}

bool take_what(const file::Order& in, What& what) {
  switch (in.what_case()) {
    case file::Order::kDrive:
      return take(in.drive(), what.emplace<Drive>());
    case file::Order::kKnob: {
      Knob& k = what.emplace<Knob>();
      return take_text(in.knob().name(), k.name) && take_text(in.knob().value(), k.value);
    }
    case file::Order::kNetem: {
      Netem& n = what.emplace<Netem>();
      return take_slot(in.netem().to(), n.to) && take_text(in.netem().spec(), n.spec);
    }
    case file::Order::kCut: {
      Cut& c = what.emplace<Cut>();
      if (in.cut().ways() >= kWaysNames.size()) return false;
      c.ways = static_cast<Ways>(in.cut().ways());
      return take_slot(in.cut().peer(), c.peer) && take_between(in.cut().seconds(), 0, kMostSeconds, c.seconds);
    }
    case file::Order::kPause:
      return take_between(in.pause().seconds(), 0, kMostSeconds, what.emplace<Pause>().seconds);
    case file::Order::kPush:
      return take(in.push(), what.emplace<Push>());
    case file::Order::WHAT_NOT_SET:
      break;
  }
  return false;
}

}  // namespace

Bytes encode(const Order& order) {
  file::Datagram d;
  file::Order& out = *d.mutable_order();
  out.set_process(order.process);
  out.set_token(order.token);
  out.set_issuer(order.issuer);
  out.set_number(order.number);
  std::visit(Put{out}, order.what);
  return to_bytes(d);
}

std::optional<Order> decode_order(std::span<const std::byte> datagram) {
  file::Datagram in;
  if (!from_bytes(datagram, in) || in.kind_case() != file::Datagram::kOrder) return std::nullopt;
  Order o;
  o.process = in.order().process();
  o.token = in.order().token();
  o.issuer = in.order().issuer();
  o.number = in.order().number();
  if (o.issuer == 0 || o.number == 0 || !take_what(in.order(), o.what)) return std::nullopt;
  return o;
}

}  // namespace padr::monitor
