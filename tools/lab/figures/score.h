#pragma once

#include <vector>

#include "common/model/ids.h"

namespace padr::lab::figures {

/// How good predictions of contacts were, by what happened then.
///
/// A warning is an unbroken stretch of ticks at which interaction is predicted while the avatar touches no body. It was
/// right if the avatar touches a body before it ends or within `horizon` ticks of its end; one that the run ends too
/// early to tell counts neither way. A contact counts if the avatar has touched no body for kFreeTicks before: what
/// bounces off and on again needs no prediction. It was foreseen if interaction was predicted at the tick before.
struct PredictionScore {
  int right = 0;       ///< warnings after which there was a contact
  int wrong = 0;       ///< warnings after which there was none
  int foreseen = 0;    ///< contacts
  int unforeseen = 0;  ///< contacts
  Tick free_ticks = 0;
  Tick warned_ticks = 0;  ///< of the free ones: what warnings cost
  Tick lead_ticks = 0;    ///< by which foreseen contacts were foreseen, summed

  /// Share of the warnings that were right, 0 .. 1; NaN if there was none.
  double precision() const;
  /// Share of the contacts that were foreseen, 0 .. 1; NaN if there was none.
  double recall() const;
  /// Share of the time without contact, 0 .. 1.
  double warned_share() const;
  /// Mean time by which foreseen contacts were foreseen, s.
  double lead_s() const;

  PredictionScore& operator+=(const PredictionScore& o);
};

/// 250 ms without a contact: as long as the low threshold lingers.
inline constexpr Tick kFreeTicks = 15;

/// `predicted` and `touching` tick by tick, equally long.
PredictionScore score_predictions(const std::vector<bool>& predicted, const std::vector<bool>& touching, Tick horizon);

}  // namespace padr::lab::figures
