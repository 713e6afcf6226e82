#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/monitor/codec.h"
#include "tools/monitor/observed_session.h"

namespace padr::monitor {

/// Datagrams of peers, counted since the start.
struct HeardStats {
  std::uint64_t datagrams = 0;
  std::uint64_t bytes = 0;
  std::uint64_t malformed = 0;
  std::uint64_t early = 0;    ///< of a session whose scene is not known yet
  std::uint64_t crowded = 0;  ///< of more sessions or scenes than are kept
};

/// Sorts what peers tell into sessions, and picks the one to look at: the one that began last of those that live; when
/// none does, the last that did.
class ObservedSessions {
 public:
  void take(std::span<const std::byte> datagram, const Endpoint& from, Micros now);
  /// Forgets what has been gone for long.
  void advance(Micros now);

  /// Null as long as there is none.
  ObservedSession* shown() { return shown_; }
  const ObservedSession* shown() const { return shown_; }
  /// Living ones besides.
  int others(Micros now) const;
  const HeardStats& stats() const { return stats_; }
  /// Lines for the log, since the last call.
  std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }

  static constexpr std::size_t kSessions = 16;
  static constexpr std::size_t kScenes = 16;
  static constexpr Micros kTryAgain = 5 * kMicrosPerSecond;

 private:
  /// A scenario's text on its way here.
  struct SceneDraft {
    std::string text;
    std::vector<char> has;
    std::size_t missing = 0;
    Micros heard = 0;
    Micros tried = -kTryAgain;  ///< when it last made no scene
  };
  void take_part(const ScenarioPart& part, Micros now);
  void found(const Told& told, Micros now);
  void choose(Micros now);

  std::map<std::uint64_t, SceneDraft> drafts_;  ///< by the scene's hash
  std::map<SessionKey, std::unique_ptr<ObservedSession>> sessions_;
  std::map<std::uint64_t, SessionKey> key_of_;  ///< by process, from its Hello
  ObservedSession* shown_ = nullptr;
  HeardStats stats_;
  std::vector<std::string> notes_;
};

}  // namespace padr::monitor
