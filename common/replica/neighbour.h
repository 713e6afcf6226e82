#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/channel/replay_window.h"
#include "common/model/endpoint.h"
#include "common/replica/link_clock.h"
#include "common/replica/one_way_delays.h"
#include "common/sync/delivery.h"
#include "common/sync/validation.h"

namespace padr::node {

enum class Presence : std::uint8_t {
  kAbsent,  ///< nobody sits in the slot, or who did has been declared gone
  kThere,
  kLeft,  ///< has said goodbye, and may linger to get its last words across
};

/// Who sat in a slot before who sits there now.
struct Former {
  std::uint32_t first = 0;  ///< number of its first update
  std::uint32_t incarnation = 0;
  Endpoint at;
};

/// Another slot of the session as seen from here, and the link with who sits in it.
struct Neighbour {
  Presence presence = Presence::kAbsent;
  std::uint32_t incarnation = 0;  ///< of who sits or sat there last
  std::uint32_t first = 0;        ///< number of its first update
  Endpoint at;
  sync::OutLink link;
  ReplayWindow window;
  LinkClock clock;
  Arrivals arrivals;
  Tick since = 0;                  ///< tick of its admission
  Tick excused = 0;                ///< nothing before this is held against it
  Tick heard = 0;                  ///< when anything valid came last
  Tick answered = 0;               ///< when it last said that it got something new of ours
  Tick answer_mark = -1;           ///< of its newest mark that has answered us
  Tick relayed = -1;               ///< of its newest update that has come by somebody else only
  Tick given_up = -1;              ///< since when it counts as silent, whatever was heard before; -1: it does not
  bool given_up_for_good = false;  ///< whoever hears it
  bool repeats = false;            ///< it has sent again what is here: it has not heard so
  std::uint32_t answered_seq = 0;
  bool proven = false;             ///< it has answered since silence was last excused
  std::uint32_t promised = 0;      ///< highest mark count heard
  Tick confirmed = 0;              ///< it has confirmed so far at least
  Tick checked = 0;                ///< when it was last told a hash
  Tick told_check = -1;            ///< of which tick
  bool differs = false;            ///< it has told a hash that is not ours
  bool frozen = false;             ///< being declared gone: nothing more is taken from it
  std::vector<sync::Bundle> held;  ///< frozen: updates of it that are here beyond the first that is not

  std::vector<Former> former;                               ///< the latest kFormer, eldest first
  std::array<std::uint64_t, sync::kDropReasons> dropped{};  ///< by reason, of whoever has sat there
  std::uint32_t cut_offs = 0;                               ///< how often who sits there now was given a deaf ear

  static constexpr std::size_t kFormer = 4;
  bool there() const { return presence == Presence::kThere; }
  /// Whether it gets our datagrams and we may get some of it.
  bool reachable() const { return presence != Presence::kAbsent; }
};

}  // namespace padr::node
