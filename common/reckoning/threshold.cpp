#include "common/reckoning/threshold.h"

#include <algorithm>

namespace padr::sync {

void Threshold::adapt(const Prediction& p, bool holding, Tick now) {
  const bool interaction = p.interaction || holding;
  const float level = holding ? 1.0F : p.level;
  if (interaction) low_until_ = now + kLinger;
  if (interaction || now > low_until_) lingering_level_ = interaction ? level : 0;
  if (technique_.law == ThresholdLaw::kContinuous) {
    const float span = technique_.threshold_high - technique_.threshold_low;
    now_m_ = technique_.threshold_high - span * std::clamp(std::max(level, lingering_level_), 0.0F, 1.0F);
  } else {
    now_m_ = now <= low_until_ ? technique_.threshold_low : technique_.threshold_high;
  }
}

}  // namespace padr::sync
