#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace padr {

/// What the others believe of an avatar between updates.
enum class Model : std::uint8_t {
  kStatic,  ///< stays where it was
  kFirst,   ///< keeps its velocity (the paper's)
  kSecond,  ///< keeps its acceleration, up to the avatar's top speed
  kInput,   ///< keeps its control state: the same control law drives it towards the same target
  kChosen,  ///< by each update anew: kInput or kSecond, whichever has lately been right. No update carries this
};

/// What the avatar's threshold is adapted to.
enum class Predictor : std::uint8_t {
  kNone,
  kLookahead,    ///< a contact within the next steps of a copy of the surroundings
  kDensity,      ///< bodies within a radius
  kPathDensity,  ///< bodies along the projected path
  kPcc,          ///< look-ahead from the true and from the modelled state: the difference they make to bodies
};

enum class ThresholdLaw : std::uint8_t { kTwoLevel, kContinuous };
enum class Convergence : std::uint8_t { kSnap, kBlend, kPvb, kTrack };

/// How states are told.
enum class Precision : std::uint8_t {
  kExact,    ///< every bit
  kRounded,  ///< in steps of 2^-14 m and rad and 2^-12 m/s and rad/s; who tells them takes them on, too
};

/// Where a body that nobody owns comes from in a player's own world.
enum class Unowned : std::uint8_t {
  kAgreed,  ///< the predicted world: all players see the same, even where nobody's own world has it so
  kLive,    ///< the player's own world, which stays its own until somebody tells of the body: our reading of the paper
};

/// Everything that makes one synchronisation technique differ from another. All fields but `authority` are a peer's
/// own affair; peers of one session must agree on `authority`.
struct Technique {
  std::string name = "full";
  bool authority = true;  ///< dynamic authority over bodies; without it every peer plays bodies out by itself
  bool replay = true;     ///< rewind and replay on late updates; without it they are applied as if true on arrival
  Model model = Model::kChosen;
  Predictor predictor = Predictor::kLookahead;
  ThresholdLaw law = ThresholdLaw::kTwoLevel;
  float lead = 0.04F;        ///< s, how far ahead of its motion the input model's target is told (Aim); 0: as it is
  float time_space = 0.04F;  ///< s, an avatar error is told once its time integral exceeds threshold x this; 0: off
  float foresee = 0.1F;      ///< s, an avatar error is told if it will be four times the threshold after this; 0: off
  float threshold_high = 0.014F;  ///< m, when nothing is predicted
  float threshold_low = 0.012F;   ///< m, when interaction is predicted; equal to the high one for a fixed threshold
  float body_threshold = 0.012F;  ///< m, for bodies under own authority; 0 switches it off
  Convergence convergence = Convergence::kTrack;
  float radius = 3.0F;     ///< m, of the surroundings that predictors look at
  int steps = 30;          ///< ticks that predictors look ahead
  int count = 4;           ///< bodies in the vicinity that make it dense
  float pcc_bound = 0.1F;  ///< m of predicted cost above which the low threshold applies
  /// Every contact and chain member is updated, as in the paper, and chain members also when they join; otherwise only
  /// what the predicted world gets wrong.
  bool update_every_contact = false;
  bool every_tick = false;   ///< the own avatar and every awake body under own authority are told at every tick
  bool end_update = true;    ///< the end of a contact carries the states it leaves; off: only that it has ended
  bool proxy_update = true;  ///< what is reached through other bodies is claimed and told too
  bool rest_state = true;    ///< what comes to rest is told exactly where; off: only that authority is given up
  Precision precision = Precision::kRounded;
  Unowned unowned = Unowned::kAgreed;
  /// Without replay: an update is moved on by its age when it arrives, as DIS practice has it; off: applied as if true
  /// on arrival, our reading of the paper.
  bool time_stamps = false;
  /// kbit/s that this peer's updates are to fit into with all that it sends to all others together, IP and UDP headers
  /// included; every link gets the same share. 0: no limit but what links carry.
  float budget = 64;
  friend bool operator==(const Technique&, const Technique&) = default;
};

/// Whether updates of the avatar may carry where it heads.
inline bool tells_input(const Technique& t) {
  return t.model == Model::kInput || t.model == Model::kChosen;
}

/// Whether bodies that nobody owns play out in the player's own world alone. Without authority nobody owns any.
inline bool plays_unowned_alone(const Technique& t) {
  return !t.authority || t.unowned == Unowned::kLive;
}

/// The first field of a technique that is out of range, as "model: 9 is not allowed; give 0 to 4"; empty if none is.
/// These are the limits of what a trace can hold; flags have narrower ones.
std::string wrong_field(const Technique& t);

/// `avatar-only`, `fixed`, `adaptive`, `full` or `everything`; UserError names them on anything else.
Technique technique_by_name(std::string_view name);
std::vector<std::string_view> technique_names();

}  // namespace padr
