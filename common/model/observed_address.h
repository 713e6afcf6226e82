#pragma once

#include "common/model/endpoint.h"

namespace padr {

/// An address that another machine tells of, as it is to be reached from here: a loopback address means the teller's
/// own machine. Unchanged if it is not known where the teller is.
inline Endpoint as_seen_from(const Endpoint& told, const Endpoint& teller) {
  Endpoint e = told;
  if (told.is_loopback() && teller.is_set() && !teller.is_loopback()) e.address = teller.address;
  return e;
}

}  // namespace padr
