#pragma once

#include <cstdint>
#include <string>

#include "common/model/endpoint.h"
#include "common/model/ids.h"

namespace padr::node {

/// An event in the session, for the host program to act on or to show; shell/session_words.h has the texts. The kind
/// says which fields are set.
struct SessionEvent {
  enum class Kind : std::uint8_t {
    kWelcomed,     ///< the member at `at` welcomes this peer, as `peer`
    kPassedOn,     ///< the peer at `at` redirects this peer to `to`
    kAdmitted,     ///< this peer, as `peer`, at `tick`
    kJoined,       ///< `peer`, which is at `at`, at `tick`
    kLeft,         ///< `peer`
    kLost,         ///< `peer`, from `tick` on
    kRefused,      ///< a joiner at `at`; `text`: why
    kUnreachable,  ///< the machine of `peer` reports that nobody listens at its address
    kSuspected,    ///< `peer` has been silent for kSilence, and members are polled for its updates
    kHeard,        ///< `peer` does not answer, but stays, as other members hear it
    kHeardAgain,   ///< as kHeard, of a peer that was suspected
    kCarried,      ///< `peer` is reached through `by`
    kRelayed,      ///< `peer` does not answer directly, and others relay its updates
    kDirect,       ///< `peer` is reached directly again
    kDropped,      ///< `count` datagrams of `peer`; `text`: why, one of sync::kDropNames
    kWithholds,  ///< `peer` does not answer polls about lost peers, or does not send the updates that it claims to have
    kMuted,      ///< `peer` is ignored for `tick` ticks; `text`: why
    kCutOff,     ///< `peer`, for good; `text`: why
    kOutvoted,   ///< a part of the session with `count` members outranks ours, which has `own`: this peer joins it at
                 ///< `at`
    kReturning,  ///< this peer joins anew; `text`: why
    kStillOut,   ///< an attempt to come in, for the first time or anew, has failed; `text`: why
    kWrongKey,   ///< `count` datagrams were not made with this session's key, the last of them at `at`
    kLastKeyLogged,  ///< keys of `count` peers have been logged, and no more will be
    kReadable,       ///< the peer at `at` sends readable datagrams, though this one encrypts
    kOtherSession,   ///< while this founder waits, the peer at `at` sends datagrams of another session
    kDiffered,       ///< the state that this peer rejoins with differs from its own of that tick; `text`: where
  };
  Kind kind{};
  PeerId peer = kNoPeer;
  PeerId by = kNoPeer;
  Tick tick = 0;
  Endpoint at{};
  Endpoint to{};
  std::uint64_t count = 0;
  std::size_t own = 0;
  std::string text{};
};

}  // namespace padr::node
