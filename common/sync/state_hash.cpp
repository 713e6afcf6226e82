#include "common/sync/state_hash.h"

#include "common/model/hash.h"

namespace padr::sync {
namespace {

std::uint64_t hash_of(const std::vector<Authority>& authority, const std::vector<PeerSet>& holds) {
  WideHasher h;
  for (std::size_t b = 0; b < authority.size(); ++b) {
    const Authority& a = authority[b];
    h.add(static_cast<std::uint64_t>(a.owner) | static_cast<std::uint64_t>(a.released) << 8U,
          static_cast<std::uint64_t>(a.epoch), static_cast<std::uint64_t>(a.claimed), holds[b]);
  }
  return h.value();
}

std::uint64_t hash_of(const Residents& r) {
  WideHasher h;
  add_to_hash(h, r);
  return h.value();
}

}  // namespace

std::uint64_t StateHasher::operator()(const FoldState& s) {
  if (!bodies_ || authority_ != s.authority || holds_ != s.holds) {
    authority_ = s.authority;
    holds_ = s.holds;
    bodies_ = hash_of(s.authority, s.holds);
  }
  if (!within_ || residents_ != s.residents) {
    residents_ = s.residents;
    within_ = hash_of(s.residents);
  }
  WideHasher h;
  h.add(static_cast<std::uint64_t>(s.tick), s.members.size() << 32U | s.authority.size(), *bodies_, *within_);
  world::add_to_hash(h, s.world);
  // Once play has begun it no longer matters when.
  if (!s.playing()) h.add(static_cast<std::uint64_t>(s.start.wanted), static_cast<std::uint64_t>(s.start.at), 0, 0);
  for (std::size_t p = 0; p < s.members.size(); ++p) {
    const Member& m = s.members[p];
    const AvatarModel& a = s.avatars[p];
    h.add(static_cast<std::uint64_t>(m.present) | static_cast<std::uint64_t>(m.incarnation) << 1U |
              static_cast<std::uint64_t>(m.going) << 33U,
          static_cast<std::uint64_t>(a.present) | static_cast<std::uint64_t>(a.at_rest) << 1U |
              static_cast<std::uint64_t>(a.kind) << 2U | static_cast<std::uint64_t>(a.since) << 8U,
          Hasher::word(a.velocity.x, a.velocity.y), Hasher::word(a.control.x, a.control.y));
  }
  return h.value();
}

std::uint64_t hash_of(const FoldState& s) {
  return StateHasher{}(s);
}

}  // namespace padr::sync
