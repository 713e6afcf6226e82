#pragma once

#include "common/model/endpoint.h"
#include "common/model/ids.h"
#include "common/wire/seal.h"

namespace padr::node {

/// A datagram for the shell to send.
struct Parcel {
  Endpoint to;
  /// Number of the peer at `to`, if this is a state datagram, or is carried.
  PeerId state_to = kNoPeer;
  wire::Bytes bytes;
};

}  // namespace padr::node
