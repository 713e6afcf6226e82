#pragma once

#include <optional>

#include "peer/options.h"
#include "tools/support/udp_socket.h"

namespace padr::peer {

/// Where a peer joins, if it does. Throws UserError.
std::optional<support::Udp::endpoint> join_address(boost::asio::io_context& io, const Options& options);
/// Where to listen, given where the others are. Throws UserError if that cannot be, or must not.
support::Udp::endpoint listen_address(boost::asio::io_context& io, const Options& options,
                                      const std::optional<support::Udp::endpoint>& join);

}  // namespace padr::peer
