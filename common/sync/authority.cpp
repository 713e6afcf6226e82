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

/// The limit on a rise is generous to honest peers; with it a liar reaches the last epoch after more than a day.
constexpr std::uint32_t kMostRise = 128;
/// A claim that did not fit its tick's update is told in one of the next.
constexpr Tick kToldLater = 2 * kTicksPerSecond;

}  // namespace

bool may_rest_on(const Authority& claim, const Authority& present, Tick told) {
  if (claim.epoch > present.epoch && claim.epoch - present.epoch > kMostRise) return false;
  const bool on_record = present.owner == claim.owner && present.epoch == claim.epoch;
  return on_record || claim.claimed >= told - kToldLater;
}

bool wins(const Authority& claim, const Authority& present, EntityId body) {
  if (claim.epoch != present.epoch) return claim.epoch > present.epoch;
  if (claim.owner == present.owner) return !present.released && claim.claimed == present.claimed;
  if (claim.claimed != present.claimed) return claim.claimed < present.claimed;
  const std::uint64_t a = lot(claim.owner, body, claim.epoch);
  const std::uint64_t b = lot(present.owner, body, present.epoch);
  return a != b ? a < b : claim.owner < present.owner;
}

}  // namespace padr::sync
