#include "common/sync/arrival_timeline.h"

namespace padr::sync {

ArrivalTimeline::ArrivalTimeline(const TimelineParts& parts)
    : parts_(parts),
      arrivals_(parts.config.slots, parts.predicted.world().bodies()),
      follower_(parts.predicted.world().scene(), parts.config.slots, 0, parts.config.authority),
      room_(parts.predicted.world()) {
  follower_.restore(parts_.confirmed);
  for (const Bundle& b : parts_.log.since(parts_.confirmed.tick)) {
    if (b.tick > parts_.predicted.tick()) {
      arrivals_.add(b);
    } else {
      arrivals_.note(b);
    }
  }
  look();
}

bool ArrivalTimeline::catch_up() {
  if (!arrivals_.any()) return false;
  arrivals_.apply_to(parts_.predicted, parts_.config.time_stamps);
  look();
  return true;
}

void ArrivalTimeline::finish() {
  parts_.budget.lift();
  catch_up();
}

void ArrivalTimeline::confirm(Tick complete) {
  while (follower_.tick() < complete && parts_.budget.may_step()) {
    for (const Bundle& b : parts_.log.at(follower_.tick())) follower_.apply(b);
    follower_.step();
    parts_.budget.spend_step(follower_);
    follower_.save(parts_.confirmed);
    parts_.announce(parts_.confirmed);
  }
  parts_.predicted.set_start(parts_.confirmed.start);  // who has come and gone may have been heard of in another order
}

}  // namespace padr::sync
