#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/sync/authority.h"
#include "common/sync/packet.h"
#include "common/wire/session_codec.h"
#include "tools/capture/distribution.h"
#include "tools/capture/input.h"
#include "tools/capture/session_log.h"

namespace padr::capture {

/// Something that happened, in the order in which the capture has it.
struct Event {
  std::int64_t time_ns = 0;
  Tick tick = -1;  ///< at which it is true; -1: before the session runs
  Incarnation by;
  std::string_view what;  ///< see kEventsHelp
  int entity = -1;        ///< body, or -1
  int other = -1;         ///< another peer's slot, or -1
  std::string detail;
};

/// Turns a capture into events, one session at a time.
class Timeline {
 public:
  void take(const Datagram& d);
  /// By session, in the order in which the capture has them. Who owns what follows from all updates in the order of
  /// their ticks, as in the confirmed world, whatever order they were captured in.
  std::map<std::uint16_t, std::vector<Event>> events() const;

 private:
  void state(const Datagram& d, std::uint16_t session, const sync::StatePacket& p, PeerId sender);
  void message(Event e, std::uint16_t session, const wire::SessionMessage& m);

  using LinkId = std::tuple<std::uint16_t, Incarnation, Endpoint, std::uint32_t>;
  std::map<std::uint16_t, std::vector<Event>> events_;
  /// An update, and the time and sender of its first copy.
  struct Told {
    Event first;
    sync::Bundle update;
  };
  std::map<std::uint16_t, std::vector<Told>> updates_;
  std::set<std::tuple<std::uint16_t, Incarnation, std::uint32_t>> told_;
  std::map<std::uint64_t, std::vector<Event>> joins_;  ///< by nonce, as they do not know the session yet
  std::map<std::uint64_t, std::uint16_t> session_of_;  ///< by nonce, as the answer tells
  std::map<LinkId, std::set<std::uint32_t>> sent_;     ///< numbers of updates
  std::map<LinkId, NumberWindow> seqs_;
  std::map<std::pair<Endpoint, std::uint32_t>, PeerId> who_;
  std::set<std::pair<std::uint16_t, Incarnation>> heard_;
};

/// For help texts.
extern const char* const kEventsHelp;

std::string timeline_csv(const std::vector<Event>& events);
std::string timeline_json(std::uint16_t session, const std::vector<Event>& events);
/// A lane for every peer, and one for every body that changed hands.
std::string timeline_svg(std::uint16_t session, const std::vector<Event>& events);

}  // namespace padr::capture
