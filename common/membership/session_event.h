#pragma once

#include <cstdint>
#include <string>

#include "common/model/endpoint.h"
#include "common/model/ids.h"

namespace padr::node {

/// What happened in the session, for a host to act on or to tell people; shell/session_words.h has the words. Which
/// fields count, the kind says.
struct SessionEvent {
  enum class Kind : std::uint8_t {
    kWelcomed,     ///< the member at `at` lets this peer in, as `peer`
    kPassedOn,     ///< whoever is at `at` sends this peer to `to`
    kAdmitted,     ///< this peer, as `peer`, at `tick`
    kJoined,       ///< `peer`, which is at `at`, at `tick`
    kLeft,         ///< `peer`
    kLost,         ///< `peer`, from `tick` on
    kRefused,      ///< a newcomer at `at`; `text`: why
    kUnreachable,  ///< nobody listens at the address of `peer` any more, as its machine says
    kSuspected,    ///< `peer` has been silent for kSilence, and the others are asked for its updates
    kHeard,        ///< `peer` does not answer, but stays, as others hear it
    kHeardAgain,   ///< the same of one that was suspected
    kDropped,      ///< `count` datagrams of `peer`; `text`: why
    kMuted,        ///< `peer` is ignored for a while; `text`: why
    kCutOff,       ///< `peer`, for good; `text`: why
    kOutvoted,   ///< a part of the session with `count` members goes on without ours, which has `own`: this peer joins
                 ///< at `at`
    kReturning,  ///< this peer joins anew; `text`: why
    kWrongKey,   ///< `count` datagrams were not made with this session's key, the last of them at `at`
    kLastKeyLogged,  ///< keys of `count` peers have been logged, and no more will be
    kDiffered,       ///< the state it comes back with differs from its own of the same tick; `text`: where
  };
  Kind kind{};
  PeerId peer = kNoPeer;
  Tick tick = 0;
  Endpoint at{};
  Endpoint to{};
  std::uint64_t count = 0;
  std::size_t own = 0;
  std::string text{};
};

}  // namespace padr::node
