#pragma once

#include <memory>
#include <span>

#include "common/world/world.h"

namespace padr::lab {

/// What the peers of a run take of a processor, against one bare Box2D world of the same scene that is stepped beside
/// them, in the same run, with the same hands. It differs from run to run, and nothing that is simulated depends on it.
class ProcessorTime {
 public:
  ProcessorTime(const Scene& scene, int peers);

  /// Around what the peers do in a tick.
  void begin();
  void end();
  /// What is done while it lives is not the peers' doing. May be null.
  class Pause {
   public:
    explicit Pause(ProcessorTime* time) : time_(time != nullptr && time->runs_ ? time : nullptr) {
      if (time_ != nullptr) time_->end();
    }
    ~Pause() {
      if (time_ != nullptr) time_->begin();
    }
    Pause(const Pause&) = delete;
    Pause& operator=(const Pause&) = delete;

   private:
    ProcessorTime* time_;
  };
  /// A step of the bare world with where the hands are (m, by peer), once a tick.
  void step_bare(std::span<const Vec2> hands);

  /// Of one peer in one tick, in steps of the bare world; 0 before there were any.
  double steps() const { return bare_s_ > 0 ? peers_s_ / static_cast<double>(peers_) / bare_s_ : 0; }

 private:
  int peers_;
  world::World bare_;
  bool runs_ = false;
  double begun_s_ = 0;
  double peers_s_ = 0;
  double bare_s_ = 0;
};

}  // namespace padr::lab
