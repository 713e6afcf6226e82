#include "tools/lab/figures/score.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace padr::lab::figures {
namespace {

double share(double part, double rest) {
  return part + rest > 0 ? part / (part + rest) : std::numeric_limits<double>::quiet_NaN();
}

enum class Verdict { kRight, kWrong, kOpen };

/// Of the warning whose first tick is `from`; `end` is set to the tick after its last.
Verdict judge(const std::vector<bool>& predicted, const std::vector<bool>& touching, std::size_t from,
              std::size_t horizon, std::size_t& end) {
  end = from;
  while (end < predicted.size() && predicted[end] && !touching[end]) ++end;
  const std::size_t last = end - 1 + horizon;
  for (std::size_t t = end; t <= std::min(last, touching.size() - 1); ++t)
    if (touching[t]) return Verdict::kRight;
  return last < touching.size() ? Verdict::kWrong : Verdict::kOpen;
}

}  // namespace

double PredictionScore::precision() const {
  return share(right, wrong);
}
double PredictionScore::recall() const {
  return share(foreseen, unforeseen);
}
double PredictionScore::warned_share() const {
  return share(warned_ticks, free_ticks - warned_ticks);
}
double PredictionScore::lead_s() const {
  return foreseen > 0 ? static_cast<double>(lead_ticks) / foreseen / kTicksPerSecond
                      : std::numeric_limits<double>::quiet_NaN();
}

PredictionScore& PredictionScore::operator+=(const PredictionScore& o) {
  right += o.right;
  wrong += o.wrong;
  foreseen += o.foreseen;
  unforeseen += o.unforeseen;
  free_ticks += o.free_ticks;
  warned_ticks += o.warned_ticks;
  lead_ticks += o.lead_ticks;
  return *this;
}

PredictionScore score_predictions(const std::vector<bool>& predicted, const std::vector<bool>& touching, Tick horizon) {
  assert(predicted.size() == touching.size() && horizon > 0);
  PredictionScore s;
  Tick free_for = kFreeTicks;  // nothing touches at the start
  Tick warned_for = 0;
  std::size_t judged_until = 0;
  for (std::size_t t = 0; t < touching.size(); ++t) {
    if (touching[t]) {
      if (free_for >= kFreeTicks) ++(warned_for > 0 ? s.foreseen : s.unforeseen);
      if (free_for >= kFreeTicks) s.lead_ticks += warned_for;
      free_for = 0;
      warned_for = 0;
      continue;
    }
    ++free_for;
    ++s.free_ticks;
    warned_for = predicted[t] ? warned_for + 1 : 0;
    if (!predicted[t]) continue;
    ++s.warned_ticks;
    if (t < judged_until) continue;
    const Verdict v = judge(predicted, touching, t, static_cast<std::size_t>(horizon), judged_until);
    if (v == Verdict::kRight) ++s.right;
    if (v == Verdict::kWrong) ++s.wrong;
  }
  return s;
}

}  // namespace padr::lab::figures
