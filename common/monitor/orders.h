#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <variant>

#include "common/model/ids.h"
#include "common/model/vec.h"

namespace padr::monitor {

// What a monitor may tell a peer that was started to obey. Every order that is new to the peer is answered by an Event
// that bears its number; only a Drive that goes on is not, each time.

/// Where the avatar goes, in place of the peer's own input. Holds for kDriveLease unless told again.
struct Drive {
  enum class Kind : std::uint8_t {
    kRelease,    ///< the own input goes on
    kPoint,      ///< towards `to`, m
    kDirection,  ///< towards `to`, each coordinate -1 .. 1; longer than 1 counts as 1, and 0, 0 stands
  };
  Kind kind = Kind::kRelease;
  Vec2 to;
  friend bool operator==(const Drive&, const Drive&) = default;
};
/// A monitor that vanishes must not leave an avatar running: repeat a Drive about five times a second.
inline constexpr Micros kDriveLease = 2 * kMicrosPerSecond;

/// A technique's setting in the words of the command line: name "threshold", value "0.8:0.3". Name "technique" sets
/// all.
struct Knob {
  std::string name;
  std::string value;
  friend bool operator==(const Knob&, const Knob&) = default;
};

/// What a link out of the peer suffers from now on, in the words of --netem; empty: nothing.
struct Netem {
  PeerId to = kNoPeer;  ///< kNoPeer: all links, and later ones
  std::string spec;
  friend bool operator==(const Netem&, const Netem&) = default;
};

enum class Ways : std::uint8_t { kBoth, kOut, kIn };
inline constexpr std::array<const char*, 3> kWaysNames{"both", "out", "in"};

/// Nothing passes from the peer to another one, from there to the peer, or either way.
struct Cut {
  PeerId peer = kNoPeer;  ///< kNoPeer: all others
  float seconds = 0;      ///< 0 .. 600; 0: whole again at once
  Ways ways = Ways::kBoth;
  friend bool operator==(const Cut&, const Cut&) = default;
};

/// The peer stands still, as if its process had been stopped.
struct Pause {
  float seconds = 0;  ///< 0 .. 600; 0: it goes on at once
  friend bool operator==(const Pause&, const Pause&) = default;
};

/// The peer takes authority over a body, if it may, and changes its velocity, as if it had touched it.
struct Push {
  EntityId body = 0;
  Vec2 velocity;  ///< m/s, added to the body's
  friend bool operator==(const Push&, const Push&) = default;
};
inline constexpr float kMostPush = 40;  ///< m/s

using What = std::variant<Drive, Knob, Netem, Cut, Pause, Push>;

/// One datagram to a peer.
struct Order {
  std::uint64_t process = 0;  ///< whom it is for, from Origin
  std::uint64_t token = 0;    ///< from Hello
  std::uint64_t issuer = 0;   ///< drawn at random when the monitor begins, not 0
  std::uint32_t number = 0;   ///< 1, 2, 3, ...; of an issuer's orders, a peer takes only newer ones than it has had
  What what;
  friend bool operator==(const Order&, const Order&) = default;
};

}  // namespace padr::monitor
