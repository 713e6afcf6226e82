#include "tools/lab/chaos/shrink.h"

#include <algorithm>

namespace padr::lab {

ChaosScript shrink(const ChaosPlay& how, const ChaosScript& script, int tries) {
  ChaosScript best = script;
  const auto fails = [&](const ChaosScript& s) { return tries-- > 0 && !play(how, s).violation.empty(); };
  // First in large pieces, then in smaller ones.
  for (std::size_t piece = std::max<std::size_t>(1, best.events.size() / 2);; piece /= 2) {
    for (std::size_t at = 0; at < best.events.size() && tries > 0;) {
      ChaosScript without = best;
      const auto from = without.events.begin() + static_cast<std::ptrdiff_t>(at);
      const auto n = std::min(piece, without.events.size() - at);
      without.events.erase(from, from + static_cast<std::ptrdiff_t>(n));
      if (fails(without)) {
        best = std::move(without);
      } else {
        at += piece;
      }
    }
    if (piece <= 1 || tries <= 0) break;
  }
  for (std::size_t at = 0; best.liar && at < best.liar->times.size() && tries > 0;) {
    ChaosScript without = best;
    without.liar->times.erase(without.liar->times.begin() + static_cast<std::ptrdiff_t>(at));
    if (fails(without))
      best = std::move(without);
    else
      ++at;
  }
  while (best.founders > (best.liar ? 3 : 2)) {
    ChaosScript fewer = best;
    --fewer.founders;
    if (!fails(fewer)) break;
    best = std::move(fewer);
  }
  return best;
}

}  // namespace padr::lab
