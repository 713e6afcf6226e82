#include "common/monitor/world_codec.h"

#include <cassert>

#include "common/monitor/places.h"

namespace padr::monitor {
namespace {

constexpr std::uint32_t kDriven = 1;
constexpr std::uint32_t kHolding = 2;
constexpr std::uint32_t kInteraction = 4;
constexpr std::uint32_t kUnownedAlone = 8;

// Keys and lengths of the columns, those of the message around them, and the length of each growing by a byte.
constexpr std::size_t kColumns = 32;
constexpr std::size_t kFlagBytes = 2;

constexpr float kMostTechnique = 1.0e6F;  // m; more than any knob allows

void put_head(const Frame& f, file::Frame& out) {
  out.set_tick(static_cast<std::uint32_t>(f.tick));
  out.set_threshold(f.threshold);
  out.set_target_x(to_millimetres(f.target.x));
  out.set_target_y(to_millimetres(f.target.y));
  out.set_flags((f.driven ? kDriven : 0) | (f.holding ? kHolding : 0) | (f.interaction ? kInteraction : 0) |
                (f.unowned_alone ? kUnownedAlone : 0));
  out.set_contact_in(static_cast<std::uint32_t>(f.contact_in + 1));
  out.set_level(f.level);
  out.set_radius(f.radius);
  out.set_total(f.total);
}

bool take_head(const file::Frame& in, Frame& f) {
  if (in.flags() > (kDriven | kHolding | kInteraction | kUnownedAlone) || in.contact_in() > 100'000) return false;
  f.driven = (in.flags() & kDriven) != 0;
  f.holding = (in.flags() & kHolding) != 0;
  f.interaction = (in.flags() & kInteraction) != 0;
  f.unowned_alone = (in.flags() & kUnownedAlone) != 0;
  f.contact_in = static_cast<Tick>(in.contact_in()) - 1;
  return take_tick(in.tick(), f.tick) && take_between(in.threshold(), 0, kMostTechnique, f.threshold) &&
         from_millimetres(in.target_x(), f.target.x) && from_millimetres(in.target_y(), f.target.y) &&
         take_between(in.level(), 0, 1, f.level) && take_between(in.radius(), 0, kMostTechnique, f.radius);
}

/// The entity's place in every view that is told, each as the difference to the one before.
struct Row {
  Whole shown, live, predicted;
  std::size_t bytes = kFlagBytes;
};

Row row_of(const Frame& f, std::size_t i) {
  Row r;
  const Whole shown = to_whole(f.shown[i]);
  r.shown = shown;
  r.bytes += size_of(r.shown);
  if (f.live.empty()) return r;
  const Whole live = to_whole(f.live[i]);
  r.live = live - shown;
  r.bytes += size_of(r.live);
  if (f.predicted.empty()) return r;
  r.predicted = to_whole(f.predicted[i]) - live;
  r.bytes += size_of(r.predicted);
  return r;
}

/// Gives out `part` as a datagram and begins the next one at entity `next`.
template <typename Part>
class Parts {
 public:
  Parts(file::Datagram& datagram, Part& part, EntityId first, std::vector<Bytes>& out)
      : datagram_(datagram), part_(part), out_(out) {
    part_.set_first(first);
    left_ = room();
  }
  /// To be called before the columns get entity `e`, which takes `bytes`.
  template <typename Clear>
  void make_room(std::size_t e, std::size_t bytes, const Clear& clear) {
    if (bytes > left_) {
      out_.push_back(to_bytes(datagram_));
      clear();
      part_.set_first(static_cast<std::uint32_t>(e));
      left_ = room();
    }
    left_ -= bytes;
  }
  void finish() { out_.push_back(to_bytes(datagram_)); }

 private:
  std::size_t room() const { return kRoom - datagram_.ByteSizeLong() - kColumns; }
  file::Datagram& datagram_;
  Part& part_;
  std::vector<Bytes>& out_;
  std::size_t left_ = 0;
};

}  // namespace

void put_world(const file::Origin& from, const Frame& f, std::vector<Bytes>& out) {
  assert(f.shown.size() == f.flags.size() && (f.live.empty() || f.live.size() == f.flags.size()) &&
         (f.predicted.empty() || (f.predicted.size() == f.flags.size() && !f.live.empty())));
  file::Datagram d;
  *d.mutable_origin() = from;
  file::Frame& part = *d.mutable_frame();
  put_head(f, part);
  Parts<file::Frame> parts(d, part, f.first, out);
  const auto clear = [&part] {
    part.mutable_entity_flags()->clear();
    part.mutable_owner()->clear();
    part.mutable_shown()->Clear();
    part.mutable_live()->Clear();
    part.mutable_predicted()->Clear();
  };
  for (std::size_t i = 0; i < f.flags.size(); ++i) {
    const Row r = row_of(f, i);
    parts.make_room(f.first + i, r.bytes, clear);
    put_flags(f.flags[i], *part.mutable_entity_flags(), *part.mutable_owner());
    put(r.shown, *part.mutable_shown());
    if (!f.live.empty()) put(r.live, *part.mutable_live());
    if (!f.predicted.empty()) put(r.predicted, *part.mutable_predicted());
  }
  parts.finish();
}

void put_world(const file::Origin& from, const Agreed& a, std::vector<Bytes>& out) {
  assert(a.at.size() == a.flags.size());
  file::Datagram d;
  *d.mutable_origin() = from;
  file::Agreed& part = *d.mutable_agreed();
  part.set_tick(static_cast<std::uint32_t>(a.tick));
  part.set_hash(a.hash);
  part.set_total(a.total);
  Parts<file::Agreed> parts(d, part, a.first, out);
  const auto clear = [&part] {
    part.mutable_entity_flags()->clear();
    part.mutable_owner()->clear();
    part.mutable_at()->Clear();
  };
  for (std::size_t i = 0; i < a.flags.size(); ++i) {
    const Whole w = to_whole(a.at[i]);
    parts.make_room(a.first + i, kFlagBytes + size_of(w), clear);
    put_flags(a.flags[i], *part.mutable_entity_flags(), *part.mutable_owner());
    put(w, *part.mutable_at());
  }
  parts.finish();
}

bool take_world(const file::Frame& in, Frame& f) {
  if (!take_head(in, f) || !take_flags(in.entity_flags(), in.owner(), in.first(), in.total(), f.flags)) return false;
  f.first = static_cast<EntityId>(in.first());
  f.total = static_cast<EntityId>(in.total());
  const std::size_t n = f.flags.size();
  Column shown;
  Column live;
  Column predicted;
  if (!take(in.shown(), n, {}, f.shown, shown)) return false;
  if (in.live().empty()) return in.predicted().empty();
  if (!take(in.live(), n, shown, f.live, live)) return false;
  return in.predicted().empty() || take(in.predicted(), n, live, f.predicted, predicted);
}

bool take_world(const file::Agreed& in, Agreed& a) {
  if (!take_tick(in.tick(), a.tick) || !take_flags(in.entity_flags(), in.owner(), in.first(), in.total(), a.flags))
    return false;
  a.hash = in.hash();
  a.first = static_cast<EntityId>(in.first());
  a.total = static_cast<EntityId>(in.total());
  Column sums;
  return take(in.at(), a.flags.size(), {}, a.at, sums);
}

}  // namespace padr::monitor
