#pragma once

#include "common/model/endpoint.h"
#include "common/model/ids.h"
#include "common/wire/seal.h"

namespace padr::node {

/// A datagram for the shell to send.
struct Parcel {
  Endpoint to;
  PeerId state_to = kNoPeer;  ///< the receiver's number, if it is a state datagram
  wire::Bytes bytes;
};

}  // namespace padr::node
