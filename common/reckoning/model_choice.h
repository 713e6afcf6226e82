#pragma once

#include <array>
#include <cstddef>

#include "common/model/ids.h"
#include "common/model/scene.h"
#include "common/model/state.h"
#include "common/model/technique.h"
#include "common/model/vec.h"

namespace padr::sync {

/// What is known of an avatar in a tick: where it is, how fast, where it heads, m, and its acceleration, m/s^2.
struct AvatarMoment {
  Vec2 position;
  Vec2 velocity;
  Vec2 aim;
  Vec2 acceleration;
};

/// Which model to tell of an avatar: the one that has lately foretold its motion better. A hand that points jumps and
/// stops, and its avatar is best foretold by where it heads (Model::kInput); who runs goes on as before, and is best
/// foretold by velocity and acceleration (Model::kSecond). Both are tried on the avatar's own past, without contacts,
/// which either model would get wrong alike. The receivers need not know how it was chosen.
class ModelChoice {
 public:
  explicit ModelChoice(const AvatarDef& avatar) : avatar_(avatar) {}

  /// Where the avatar is so many ticks later by that model, if it touches nothing. Model::kChosen: as kInput.
  Vec2 foretold(Model model, AvatarMoment m, Tick ticks) const;

  /// The avatar after this tick's step, and what would be told of it now: the point that it heads for, m, and its
  /// acceleration, m/s^2. `way`: ticks that an update takes to its receivers.
  void follow(const BodyState& truth, Vec2 aim, Vec2 acceleration, Tick way);
  /// Model::kInput until kSecond is clearly better.
  Model best() const { return second_error_ < kClearly * input_error_ ? Model::kSecond : Model::kInput; }

 private:
  /// An update is believed until the next one comes: for its way, and about so many ticks between two.
  static constexpr Tick kBetween = 9;
  static constexpr std::size_t kLongest = 60;
  /// Errors are averaged over about so many ticks: less, and single turns decide; more, and a hand that has begun to
  /// point is taken for one that runs for too long.
  static constexpr float kAveraged = 30;
  /// A model that is better by less would be changed for the other again and again.
  static constexpr float kClearly = 0.5F;

  AvatarDef avatar_;
  std::array<AvatarMoment, kLongest> past_{};
  std::size_t seen_ = 0;
  float input_error_ = 0;   ///< m, averaged
  float second_error_ = 0;  ///< m, averaged
};

}  // namespace padr::sync
