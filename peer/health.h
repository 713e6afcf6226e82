#pragma once

#include <optional>
#include <string>

#include "peer/log.h"
#include "peer/player.h"

namespace padr::peer {

/// What the health file tells.
struct HealthState {
  bool playing = false;
  bool healthy = false;  ///< playing, and confirmed has advanced within Health::kPatience
  std::optional<PeerId> peer;
  int present = 0;         ///< peers that are there, this one included
  Tick confirmed = -1;     ///< newest confirmed tick; -1: none
  std::uint64_t hash = 0;  ///< of the confirmed world
  Micros still = 0;        ///< since confirmed last advanced, us
};

/// A file for those who watch the process from outside, such as a container engine: JSON, replaced as a whole once in
/// kPeriod as long as the process runs, and removed when it ends. So a file that is not fresh means a peer that hangs
/// or was killed.
class Health {
 public:
  static constexpr Micros kPeriod = kMicrosPerSecond;
  /// Longer than it takes the others to declare a silent peer gone, for until then confirmed waits for it.
  static constexpr Micros kPatience = 10 * kMicrosPerSecond;

  /// Throws UserError if the file cannot be written. `log` must outlive it.
  Health(const std::string& file, Log& log);

  /// Brings it up to `now`: writes if it is time to. What cannot be written later on is said in the log.
  void update(const Player& player, Micros now);
  Micros next_due() const { return next_; }
  void remove();

 private:
  HealthState state(const Player& player, Micros now);
  /// Why it could not be done; empty if it could.
  std::string write(const HealthState& s) const;

  std::string file_;
  Log& log_;
  std::string wrong_;  ///< why it could not be written last; empty: it was
  Micros next_ = 0;
  Tick confirmed_ = -1;
  int incarnation_ = -1;
  Micros advanced_ = 0;  ///< when confirmed last did
};

}  // namespace padr::peer
