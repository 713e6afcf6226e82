#pragma once

#include <array>
#include <vector>

#include "common/reckoning/aim.h"
#include "common/reckoning/contact_chain.h"
#include "common/reckoning/entity_error.h"
#include "common/reckoning/live_world.h"
#include "common/reckoning/model_choice.h"
#include "common/reckoning/model_error.h"
#include "common/reckoning/reasons.h"
#include "common/sync/fold.h"

namespace padr::sync {

/// Collects, tick by tick, what the others must be told: the difference between the live world, which is the truth for
/// what this peer owns, and the predicted one, which is what the others believe. Whether something is due, and why, the
/// rules in reasons.h say; the timers that they ask for are kept here.
class Reporter {
 public:
  Reporter(const Scene& scene, PeerId self, const Technique& technique);
  /// From the next report on; `authority` must stay.
  void retune(const Technique& technique);
  /// Of an update at most: kMaxBodiesPerBundle until told otherwise.
  void limit_bodies(std::size_t most) { most_bodies_ = most; }

  struct Situation {
    const LiveWorld* live = nullptr;
    const FoldState* predicted = nullptr;  ///< same tick, without this tick's own updates
    Vec2 target;                           ///< m, control state of the own avatar
    Vec2 acceleration;                     ///< m/s^2, of the own avatar over the last step
    float threshold = 0;                   ///< m, in force for the avatar
    Tick round_trip = 0;                   ///< ticks; how long a lost contest keeps this peer from claiming again
    Tick everyone_has = -1;                ///< all peers have this peer's updates up to this tick
    std::vector<EntityId> pushed{};  ///< bodies that have just been pushed: told as if the avatar had touched them
    bool may_tell = true;            ///< some link takes no more for now: what is due waits, and is told as it is then
    float price = 1;                 ///< by what the thresholds are multiplied, that of the avatar already
  };
  /// Takes in how far off the avatar's model is at this tick; before the look-ahead and `report`.
  void watch_avatar(const Situation& s);
  /// Whether this tick's model error would be told by one of the thresholds that may be in force but not by all of
  /// them: only then it matters what is predicted. `coarseness`: by what the high one is
  /// multiplied, `price`: both.
  bool depends_on_threshold(float coarseness, float price) const {
    return model_error_.exceeds(technique_.threshold_low * price) &&
           !model_error_.exceeds(technique_.threshold_high * coarseness * price);
  }
  /// The updates of this tick, good until the next call: an empty bundle (no avatar, no bodies) if the others' beliefs
  /// are right. Peer and tick are filled in, the index is the caller's.
  const Bundle& report(const Situation& s);

  /// Whether the avatar touches a body right now.
  bool holding() const { return holding_; }
  /// Whether this peer may change what the body does, as its owner or by claiming it now.
  bool may_change(const FoldState& predicted, EntityId b) const {
    return predicted.authority[b].holder() == self_ || may_claim(predicted, b);
  }
  /// Whether it touches this one, or let go of it so lately that the contact counts as lasting.
  bool holds(EntityId b) const { return chain_.held(b); }
  /// Times this peer lost a contest for a body.
  int contests_lost() const { return contests_lost_; }

 private:
  void note_owned(const Situation& s);
  void report_contacts(const Situation& s);
  void report_touch(const Situation& s, EntityId b);
  void report_pushes(const Situation& s);
  void report_proxies(const Situation& s);
  void report_bodies(const Situation& s);
  void report_avatar(const Situation& s);
  /// How far apart the avatar will be after Technique::foresee by what would be told now and by what is believed, m.
  float error_ahead(const Situation& s) const;
  /// Ticks that an update takes to the others.
  static Tick way(const Situation& s) { return s.round_trip / 2; }
  /// What the avatar and its input did this tick, whatever is told of it.
  void follow_avatar(const Situation& s, const BodyState& truth);
  OwnAvatar own_avatar(const Situation& s, const BodyState& truth) const;
  bool anything_differs(const Situation& s) const;
  void bound_the_sum(const Situation& s);
  void complete_cluster(const Situation& s);
  bool may_claim(const FoldState& predicted, EntityId b) const;
  bool may_claim(const Situation& s, EntityId b) const { return may_claim(*s.predicted, b); }
  bool at_rest(const Situation& s, EntityId b);
  bool owns(const Situation& s, EntityId b) const { return s.predicted->authority[b].holder() == self_; }
  EntityError error_of(const Situation& s, EntityId e) const;
  BodyUpdate& entry(EntityId b, Cause cause);
  /// What is being collected of the body; null: nothing.
  const BodyUpdate* collected(EntityId b) const;
  void tell_state(const Situation& s, EntityId b, Cause cause);
  void claim(const Situation& s, EntityId b, Cause cause);
  void tell_avatar(const Situation& s, Cause cause);
  /// For an update of the own avatar.
  Model model_for(Cause cause) const;
  void renew_what_waited(const Situation& s);
  const Bundle& tell_nothing();
  const Bundle& finish(const Situation& s);

  PeerId self_;
  Technique technique_;
  std::size_t most_bodies_ = kMaxBodiesPerBundle;
  std::vector<float> rim_;  ///< m, by body: distance from the centre that turns fastest
  ContactChain chain_;
  Aim aim_;
  ModelChoice choice_;
  ModelError model_error_;
  std::vector<Tick> no_claim_before_;
  std::vector<char> owned_;        ///< by body, last tick
  std::vector<char> claiming_;     ///< by body: claimed, and not known yet to be owned or lost
  std::vector<Tick> claim_told_;   ///< by body: tick of this peer's last claim
  std::vector<Tick> still_since_;  ///< by body: last tick it moved
  std::vector<Tick> rest_told_;    ///< by body: when it was last told to rest while held
  std::vector<EntityId> mine_;     ///< bodies that are owned, ascending
  std::vector<char> reached_;
  std::vector<EntityId> found_;
  std::vector<BodyUpdate> bodies_;  ///< being collected, by body; what does not fit one bundle waits for the next tick
  std::optional<AvatarUpdate> avatar_;
  const ChainChanges* changes_ = nullptr;  ///< of this tick
  Bundle told_;
  Vec2 last_target_;
  Vec2 last_place_;         ///< of the avatar
  Tick target_since_ = 0;   ///< since when the input has been the same
  Tick avatar_driven_ = 0;  ///< last tick anything drove the avatar
  Tick avatar_rest_told_ = -1000;
  Tick avatar_moved_ = 0;   ///< last tick the avatar moved
  Tick settled_told_ = -1;  ///< when steady input or a standing avatar was last told exactly
  bool exact_ = false;      ///< this tick tells everything that differs in any bit
  bool holding_ = false;
  bool waited_ = false;  ///< something that was due last tick was not told
  int contests_lost_ = 0;
};

}  // namespace padr::sync
