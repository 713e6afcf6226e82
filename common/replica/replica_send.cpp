// A Replica's part in sending: what goes out to whom in a tick, and what is kept because somebody lacks it.
#include <algorithm>

#include "common/replica/replica.h"
#include "common/wire/codec.h"

namespace padr::node {
namespace {

// Offset in ticks between the marks of consecutive peers: no divisor of any of their intervals.
constexpr Tick kPhase = 11;
// Loss below which a link is calm: see OutLink.
constexpr float kCalmLoss = 0.02F;
// Time for which updates are kept although all peers have them: a joiner has only what its source had when it asked.
constexpr Tick kKept = 15 * kTicksPerSecond;
// Time for which others' updates are kept at most. A member that is further behind joins anew, or tells no hash, which
// says what it has confirmed.
constexpr Tick kKeptAtMost = 64 * kTicksPerSecond;
// Interval between hashes when updates leave no room for marks; otherwise each hash goes out once, with a mark.
constexpr Tick kTellCheck = 60;
// The same for each other peer, in a large session: ten hashes a second reach each peer, so whoever differs finds it
// out as soon as in a small one.
constexpr Tick kTellCheckPerPeer = 6;
constexpr double kBytesPerKbit = 125;
// Ticks after the last one that counted as held up that are still made too late, as a peer makes up for what it missed.
constexpr Tick kMakesUp = 24;
// Of the ticks that it makes far too late, one after the other, it sends in every eighth only: one datagram holds the
// updates of all of them, and a narrow uplink would take seconds for one of each.
constexpr Tick kTogether = 8;
// Time without new updates after which marks are less urgent.
constexpr Tick kQuiet = kTicksPerSecond;

}  // namespace

int Replica::links() const {
  int links = 0;
  for (PeerId p = 0; p < config_.slots; ++p)
    if (p != config_.self && seat(p).reachable()) ++links;
  return links;
}

void Replica::send() {
  sent_ = 0;
  const int others = links();
  const double budget = config_.technique.budget;
  const double share = budget > 0 ? budget * kBytesPerKbit / std::max(1, others) : sync::LinkRate::kMost;
  const Tick check_every = std::max(kTellCheck, kTellCheckPerPeer * others);
  const bool is_late = now() - roster_.late <= kMakesUp;
  const bool waits = now() - roster_.late == 1 && now() % kTogether != 0;
  std::uint32_t everyone = own_end();
  for (PeerId p = 0; p < config_.slots; ++p) {
    LinkState& to = links_[p];
    Seat& n = roster_.seats[p];
    n.unacknowledged = -1;
    to.out.rate().bound(share);
    if (p == config_.self || !member() || !n.reachable() || roster_.departed(p)) continue;
    const sync::UpdateLog& log = agreed_.log();
    const bool staying = !gone_ && n.there();
    const bool calm = to.window.judged() && to.window.loss() < kCalmLoss && staying;
    const bool quiet = now() - news_ > kQuiet && staying;
    const sync::OutLink::Context context{now(), log.have(p), log.have_beyond(p),    to.promised > log.have(p),
                                         calm,  quiet,       config_.self * kPhase, to.repeats};
    sync::StatePacket* packet =
        waits ? nullptr
              : to.out.compose(context, own_log_, own_first_, wire::encoded_size,
                               std::min(wire::kMaxPayload - wire::kStateOverhead, to.out.rate().half_second()));
    everyone = std::min(everyone, to.out.acked());
    if (const std::uint32_t acked = std::max(to.out.acked(), own_first_); acked < own_end())
      n.unacknowledged = own_log_[acked - own_first_].tick;
    if (packet == nullptr) continue;
    to.repeats = false;
    fill(*packet, p, check_every);
    if (sent_ == outgoing_.size()) outgoing_.emplace_back().bytes.reserve(wire::kMaxDatagram);
    Outgoing& o = outgoing_[sent_++];
    o.to = p;
    wire::seal({wire::Kind::kState, config_.self, config_.session}, encoder_.encode(*packet), o.bytes);
    ++stats_.datagrams_sent;
    stats_.wire_bytes_sent += o.bytes.size() + kIpUdpBytes;
    to.out.left(o.bytes.size() + kIpUdpBytes, now(), is_late);
  }
  stats_.repeats = repeats_of_gone_;
  for (const LinkState& l : links_) stats_.repeats += l.out.repeats();
  keep_logs(everyone);
}

void Replica::keep_logs(std::uint32_t everyone) {
  while (own_first_ < everyone && !own_log_.empty() && own_log_.front().tick < now() - kKept) {
    own_pool_.give_back(own_log_.pop_front());
    ++own_first_;
  }
  // A peer that falls silent may have sent one member updates that others lack. Only a joiner lacks what all confirmed.
  Tick all = std::min(agreed_.confirmed().tick, now() - kKept);
  for (PeerId p = 0; p < config_.slots; ++p)
    if (p != config_.self && seat(p).there()) all = std::min(all, seat(p).confirmed);
  agreed_.keep_from(std::max(all, now() - kKeptAtMost));
}

void Replica::fill(sync::StatePacket& packet, PeerId p, Tick check_every) {
  LinkState& to = links_[p];
  packet.incarnation = config_.incarnation;
  packet.to_incarnation = seat(p).incarnation;
  // Marks carry what is not urgent.
  const bool mark = packet.updates.empty();
  const HashChecks::Own newest = checks_.newest();
  const bool late = now() - to.checked >= check_every;
  if (mark || late) packet.loss = static_cast<std::uint32_t>(to.window.loss() * 100);
  const bool early = mark && newest.tick > to.told_check && check_every == kTellCheck;
  if (!late && !early) return;
  to.checked = now();
  to.told_check = newest.tick;
  if (to.clock.measured()) packet.transit = static_cast<std::int32_t>(to.clock.least() / 100);
  const HashChecks::Own* const contested = contested_check(p);
  const HashChecks::Own told = contested != nullptr ? *contested : newest;
  if (told.tick < 0) return;
  packet.check_tick = told.tick;
  packet.check_hash = told.hash;
}

// Of two whose confirmed worlds differ the other one may be stuck, and know nothing of it: it never gets to the tick of
// our newest hash.
const HashChecks::Own* Replica::contested_check(PeerId p) const {
  const Seat& s = seat(p);
  return s.differs && now() - s.disputed < kTellContested ? checks_.own(s.differs_at) : nullptr;
}

}  // namespace padr::node
