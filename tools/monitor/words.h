#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/monitor/observed_session.h"

namespace padr::monitor {

// The messages to pages as JSON in one line; page/PROTOCOL.md says what is in them.

struct HelloWords {
  std::string mode = "live";  ///< live, trace or capture
  bool control = false;
  bool needs_token = false;
  std::string source;
  std::string sample;  ///< name; empty: none is shown
};
std::string hello_text(const HelloWords& h);

std::string scene_text(const ObservedSession& s);

/// Who drives a slot, as one viewer sees it: "no", "you" or "other".
using Driven = std::function<std::string_view(PeerId slot)>;
std::string peers_text(const ObservedSession& s, int other_sessions, const Driven& driven, Micros now);

std::string series_text(const SeriesPoint& p);
std::string history_text(const std::deque<SeriesPoint>& points);
inline constexpr std::size_t kHistoryPoints = 1000;

std::string events_text(std::span<const SessionEvent> events);

struct TimelineWords {
  Tick first = 0, last = 0, tick = 0;
  bool playing = false;
  double speed = 1;
  Tick sample = 1;
};
std::string timeline_text(const TimelineWords& t);

std::string answer_text(std::optional<std::uint64_t> id, bool ok, std::string_view text, std::string_view about);
std::string taken_text(PeerId slot);

/// All in one, each a text of the above, empty for null.
std::string session_text(std::string_view hello, std::string_view scene, std::string_view peers,
                         std::string_view series);

}  // namespace padr::monitor
