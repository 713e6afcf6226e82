#include "common/sync/authority.h"

#include "common/model/hash.h"

namespace padr::sync {
namespace {

std::uint64_t lot(PeerId peer, EntityId body, std::uint32_t epoch) {
  Hasher h;
  h.add(static_cast<std::uint64_t>(peer));
  h.add(static_cast<std::uint64_t>(body));
  h.add(static_cast<std::uint64_t>(epoch));
  return h.value();
}

}  // namespace

bool wins(const Authority& claim, const Authority& present, EntityId body) {
  if (claim.epoch != present.epoch) return claim.epoch > present.epoch;
  if (claim.owner == present.owner) return !present.released && claim.claimed == present.claimed;
  if (claim.claimed != present.claimed) return claim.claimed < present.claimed;
  const std::uint64_t a = lot(claim.owner, body, claim.epoch);
  const std::uint64_t b = lot(present.owner, body, present.epoch);
  return a != b ? a < b : claim.owner < present.owner;
}

}  // namespace padr::sync
