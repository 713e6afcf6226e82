#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/model/scene.h"
#include "common/sync/fold.h"
#include "tools/capture/session_log.h"

namespace padr::capture {

/// What a capture of a session must have told, or the user.
struct Setting {
  Scene scene;
  std::string label;     ///< of the scenario, for people
  bool checked = false;  ///< its hash is that of a Join in the capture
  int slots = 0;
  int peers = 1;   ///< at tick 0
  int wanted = 0;  ///< members that play waits for; 0: not known, and so how the session begins
  bool authority = true;
};

/// A part of the confirmed world that follows from the capture.
struct Stretch {
  Tick from = 0;
  bool transfer = false;  ///< begins with what a newcomer was given; otherwise with the session
  Tick to = 0;            ///< the world at the begin of this tick is the last one
  std::string why;        ///< it ends there
  bool gap = false;       ///< because something is missing; otherwise the capture says no more
};

struct Rebuilt {
  struct Hash {
    SessionLog::Check check;
    bool agrees = false;
  };
  std::vector<Stretch> stretches;
  std::vector<Hash> hashes;         ///< those of ticks that were reached
  std::uint64_t before = 0;         ///< hashes told of ticks before the first stretch
  std::uint64_t unreached = 0;      ///< hashes told of others
  std::uint64_t given_up = 0;       ///< hashes told by a side that a partition left behind, not compared
  std::uint64_t unbelievable = 0;   ///< updates that no receiver takes
  std::uint64_t bad_transfers = 0;  ///< that do not decode
  std::uint64_t agreeing() const;
  /// Whether any tick was reached beyond those that it begins with.
  bool got_anywhere() const;
};

/// Called for the world at the begin of every tick reached, in order, with its hash.
using WorldSink = std::function<void(const sync::FoldState&, std::uint64_t hash)>;

/// Folds the updates of a session into its confirmed world, as every peer does, and holds it against the hashes that
/// they told. What is missing ends a stretch; a transfer in the capture begins another. If all have left, it goes on to
/// tick `until` if that is later than what the capture reaches by itself.
Rebuilt rebuild(const SessionLog& session_log, const Setting& setting, Tick until, const WorldSink& sink);

}  // namespace padr::capture
