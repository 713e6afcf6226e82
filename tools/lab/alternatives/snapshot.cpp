#include "tools/lab/alternatives/snapshot.h"

#include <algorithm>

#include "tools/lab/alternatives/between.h"

namespace padr::lab::alternatives {
namespace {

constexpr Tick kIdle = 30;
constexpr int kNumberBits = 8;
constexpr int kBackBits = 8;  // of the baseline, in snapshots
constexpr int kSequenceBits = 16;
constexpr std::size_t kKept = 256;
constexpr Fields kAvatarFields{.turns = false, .moves = false};
constexpr Fields kBodyFields{.turns = true, .moves = false};
// Room for the header before bodies, and for the count and the end of the list after them.
constexpr std::size_t kSpareBits = 128;

const Content* find(const std::deque<Content>& list, Tick tick) {
  const auto found = std::find_if(list.begin(), list.end(), [tick](const Content& c) { return c.tick == tick; });
  return found == list.end() ? nullptr : &*found;
}

}  // namespace

Snapshot::Snapshot(const Scene& scene, const AlternativeConfig& config)
    : Replica(scene, config),
      quantiser_(scene, config.spec.steps_per_m),
      shown_claim_(static_cast<std::size_t>(world_.bodies())) {
  for (EntityId b = 0; b < world_.bodies(); ++b)
    initial_.bodies.push_back({false, 0, false, quantiser_.place(world_.state(b))});
  for (EntityId e = 0; e < world_.entities(); ++e) shown_.push_back(world_.state(e));
  for (PeerId p = 0; p < peers(); ++p) {
    Link link;
    link.playout = Playout(kTicksPerSecond / spec().hz);
    links_.push_back(std::move(link));
  }
}

// --- sending

Content Snapshot::present() const {
  Content c = initial_;
  c.tick = now();
  c.avatar = quantiser_.place(world_.state(avatar()));
  for (EntityId b = 0; b < world_.bodies(); ++b)
    if (claims_.mine(b))
      c.bodies[b] = {true, claims_.of(b).sequence, claims_.of(b).held, quantiser_.place(world_.state(b))};
  return c;
}

void Snapshot::write_piece(BitWriter& w, const Piece& base, const Piece& p) const {
  w.flag(p.mine);
  if (!p.mine) return;
  const bool same_claim = base.mine && base.sequence == p.sequence;
  w.flag(same_claim);
  if (!same_claim) w.put(p.sequence, kSequenceBits);
  w.flag(p.held);
  quantiser_.write(w, p.state, base.state, kBodyFields);
}

bool Snapshot::read_piece(BitReader& r, Piece& p) const {
  const Piece base = p;
  p.mine = r.flag();
  if (p.mine) {
    if (!r.flag()) p.sequence = static_cast<std::uint16_t>(r.get(kSequenceBits));
    p.held = r.flag();
    p.state = quantiser_.read(r, base.state, kBodyFields);
  }
  return r.ok();
}

/// Bodies that differ from the base, each with the gap to the one before. What does not fit stays as in the base, in
/// `here` too, and waits for the next snapshot; those begin with another body each time. Returns how many states.
std::uint64_t Snapshot::write_content(BitWriter& w, const Content& base, Content& here) const {
  const std::size_t n = here.bodies.size();
  const std::size_t start = n == 0 ? 0 : static_cast<std::size_t>(now()) * 7 % n;
  std::size_t used = w.bits() + kSpareBits;
  std::vector<char> chosen(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t b = (start + i) % n;
    if (here.bodies[b] == base.bodies[b]) continue;
    BitWriter piece;
    write_piece(piece, base.bodies[b], here.bodies[b]);
    constexpr std::size_t kGapBits = 20;
    if (used + kGapBits + piece.bits() > wire::kMaxPayload * 8) {
      here.bodies[b] = base.bodies[b];
      continue;
    }
    used += kGapBits + piece.bits();
    chosen[b] = 1;
  }
  quantiser_.write(w, here.avatar, base.avatar, kAvatarFields);
  const auto count = static_cast<std::uint32_t>(std::count(chosen.begin(), chosen.end(), 1));
  w.put_small(count);
  std::uint32_t next = 0;
  for (std::uint32_t b = 0; b < n; ++b) {
    if (chosen[b] == 0) continue;
    w.put_small(b - next);
    write_piece(w, base.bodies[b], here.bodies[b]);
    next = b + 1;
  }
  return count + 1;
}

bool Snapshot::read_content(BitReader& r, Content& out) const {
  out.avatar = quantiser_.read(r, out.avatar, kAvatarFields);
  const std::uint32_t count = r.get_small();
  std::uint32_t b = 0;
  for (std::uint32_t i = 0; i < count; ++i, ++b) {
    b += std::min<std::uint32_t>(r.get_small(), kNoEntity);
    if (!r.ok() || b >= out.bodies.size() || !read_piece(r, out.bodies[b])) return false;
    if (!out.bodies[b].mine) out.bodies[b] = initial_.bodies[b];
  }
  return r.ok();
}

/// Nothing new that the other end is not known to have, and nothing of its own that it waits to have acknowledged.
bool Snapshot::idle(const Link& link, const Content& here) const {
  return !link.sent.empty() && here.same_as(link.sent.front()) && !link.owes_ack && now() - link.sent_at < kIdle;
}

void Snapshot::send_to(PeerId to, const Content& present) {
  Link& link = links_[to];
  if (idle(link, present)) return;
  const Tick every = kTicksPerSecond / spec().hz;
  const bool has_base = !link.sent.empty() && link.sent.front().tick >= 0;
  const Tick back = has_base ? (now() - link.sent.front().tick) / every : 0;
  const bool based = has_base && back < (1 << kBackBits);
  Content here = present;
  BitWriter w;
  w.put(++link.number, kNumberBits);
  w.put(static_cast<std::uint32_t>(now()) & 0xFFFFU, kTickBits);
  w.flag(based);
  if (based) w.put(static_cast<std::uint32_t>(back), kBackBits);
  w.flag(link.newest >= 0);
  if (link.newest >= 0) w.put(static_cast<std::uint32_t>(link.newest) & 0xFFFFU, kTickBits);
  const std::uint64_t states = write_content(w, based ? link.sent.front() : initial_, here);
  link.sent_at = now();
  link.owes_ack = false;
  if (link.sent.empty()) {
    link.sent.push_back(initial_);
    link.sent.back().tick = -1;  // a place for what is acknowledged: nothing yet
  }
  link.sent.push_back(std::move(here));
  if (link.sent.size() > kKept) link.sent.erase(link.sent.begin() + 1);
  post(to, w, states);
}

void Snapshot::send() {
  if (now() % (kTicksPerSecond / spec().hz) != 0) return;
  const Content here = present();
  for (PeerId p = 0; p < peers(); ++p)
    if (p != self()) send_to(p, here);
}

// --- receiving

/// The front of what was sent becomes the one that has been acknowledged.
void Snapshot::forget(Link& link, Tick acknowledged) {
  if (link.sent.empty() || acknowledged <= link.sent.front().tick || find(link.sent, acknowledged) == nullptr) return;
  while (link.sent.front().tick < acknowledged) link.sent.pop_front();
}

bool Snapshot::take(PeerId from, BitReader& r) {
  Link& link = links_[from];
  const auto number = static_cast<std::uint8_t>(r.get(kNumberBits));
  const Tick tick = whole_tick(r.get(kTickBits), now());
  const bool based = r.flag();
  const Tick back = based ? static_cast<Tick>(r.get(kBackBits)) * (kTicksPerSecond / spec().hz) : 0;
  const bool has_ack = r.flag();
  const Tick ack = has_ack ? whole_tick(r.get(kTickBits), now()) : -1;
  if (!r.ok() || find(link.received, tick) != nullptr) return false;
  Content c = initial_;
  if (based) {
    const Content* base = find(link.received, tick - back);
    if (base == nullptr) return false;
    c = *base;
  }
  if (!read_content(r, c)) return false;
  c.tick = tick;
  if (has_ack) forget(link, ack);
  link.owes_ack = link.owes_ack || link.received.empty() || !c.same_as(link.received.back());
  link.newest = std::max(link.newest, tick);
  link.received.push_back(c);
  if (link.received.size() > kKept) link.received.pop_front();
  link.playout.add(c, number, now() + 1);
  if (tick != link.newest) return true;  // late: only for the picture
  for (EntityId b = 0; b < c.bodies.size(); ++b)
    if (c.bodies[b].mine) claims_.hear(b, {from, c.bodies[b].sequence, c.bodies[b].held, c.bodies[b].state.awake});
  return true;
}

// --- showing

void Snapshot::place_avatar(PeerId p) {
  const auto m = links_[p].playout.moment(now());
  if (!m) return;
  const auto of = [](const Content* c) { return c == nullptr ? nullptr : &c->avatar; };
  const EntityId e = world_.avatar(p);
  shown_[e] = between(quantiser_, {of(m->before), of(m->a), of(m->b), of(m->after)}, *m);
}

/// Of all peers that own the body at the time at which each is shown, the one with the best claim.
void Snapshot::place_body(EntityId b) {
  shown_[b].velocity = {};
  shown_[b].spin = 0;
  for (PeerId p = 0; p < peers(); ++p) {
    if (p == self()) continue;
    const auto m = links_[p].playout.moment(now());
    if (!m || !m->a->bodies[b].mine) continue;
    const Piece& piece = m->a->bodies[b];
    const Claim claim{p, piece.sequence, piece.held, piece.state.awake};
    if (beats(shown_claim_[b], claim, b)) continue;
    shown_claim_[b] = claim;
    const auto of = [b, &piece](const Content* c) -> const Quantised* {
      if (c == nullptr || !c->bodies[b].mine || c->bodies[b].sequence != piece.sequence) return nullptr;
      return &c->bodies[b].state;
    };
    shown_[b] = between(quantiser_, {of(m->before), of(m->a), of(m->b), of(m->after)}, *m);
  }
}

void Snapshot::place_others() {
  for (PeerId p = 0; p < peers(); ++p) {
    if (p == self()) continue;
    links_[p].playout.advance(now());
    place_avatar(p);
    world_.set_state(world_.avatar(p), shown_[world_.avatar(p)]);
  }
  for (EntityId b = 0; b < world_.bodies(); ++b) {
    if (claims_.mine(b)) {
      shown_claim_[b] = claims_.of(b);
      shown_[b] = world_.state(b);
      continue;
    }
    place_body(b);
    world_.set_state(b, shown_[b]);
  }
}

}  // namespace padr::lab::alternatives
