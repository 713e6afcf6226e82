#pragma once

#include <optional>

#include "peer/options.h"
#include "shell/udp_socket.h"

namespace padr::peer {

/// Where a peer joins, if it does. Throws UserError.
std::optional<shell::Udp::endpoint> join_address(boost::asio::io_context& io, const Options& options);
/// Where to listen, given where the others are. Throws UserError if that cannot be, or must not.
shell::Udp::endpoint listen_address(boost::asio::io_context& io, const Options& options,
                                    const std::optional<shell::Udp::endpoint>& join);

}  // namespace padr::peer
