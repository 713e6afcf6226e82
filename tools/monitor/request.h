#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "common/model/ids.h"
#include "common/monitor/orders.h"

namespace padr::monitor {

/// The views that a page can have of a world; see page/PROTOCOL.md.
enum class Which : std::uint8_t { kShown, kLive, kPredicted, kConfirmed, kAuthority };
inline constexpr std::size_t kWhiches = 5;
inline constexpr std::array<std::string_view, kWhiches> kWhichNames{"shown", "live", "predicted", "confirmed",
                                                                    "authority"};

// What a page asks for; page/PROTOCOL.md has the messages.

struct Subscribe {
  unsigned views = 1;  ///< bit i: Which i
  int rate = 20;       ///< times a second at most, 1 .. 60
  friend bool operator==(const Subscribe&, const Subscribe&) = default;
};
struct GiveToken {
  std::string token;
  friend bool operator==(const GiveToken&, const GiveToken&) = default;
};
/// Something for a peer to do.
struct Command {
  PeerId peer = kNoPeer;  ///< kNoPeer: all; of a push, anyone
  What what;
  friend bool operator==(const Command&, const Command&) = default;
};

// Of a recording:

struct Play {
  bool on = true;
  friend bool operator==(const Play&, const Play&) = default;
};
struct Seek {
  Tick tick = 0;
  friend bool operator==(const Seek&, const Seek&) = default;
};
struct StepBy {
  Tick ticks = 1;  ///< may be negative
  friend bool operator==(const StepBy&, const StepBy&) = default;
};
struct Speed {
  double times = 1;  ///< 0.05 .. 20
  friend bool operator==(const Speed&, const Speed&) = default;
};

using Request = std::variant<Subscribe, GiveToken, Command, Play, Seek, StepBy, Speed>;

/// A message of a page, read.
struct Asked {
  std::optional<std::uint64_t> id;  ///< to be repeated in the answer
  std::string about;                ///< its type, if it could be read that far
  std::optional<Request> request;
  std::string wrong;  ///< why there is none: one line for people
  std::string doubt;  ///< what is legal in it, but may not be what was meant: one line for people, or empty
};

/// Checks every field; never throws.
Asked read_request(std::string_view text);

}  // namespace padr::monitor
