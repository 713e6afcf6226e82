#pragma once

#include <string>
#include <vector>

#include "common/model/endpoint.h"
#include "peer/options.h"
#include "shell/udp_socket.h"

namespace padr::peer {

/// Somebody to join by.
struct Contact {
  std::string text;  ///< as it was written
  Endpoint at;
};

/// Whom a peer joins by, in turn, if it does: all addresses of each. Throws UserError.
std::vector<Contact> join_addresses(boost::asio::io_context& io, const Options& options);
/// Where to listen, given where the others are. Throws UserError if that cannot be, or must not.
shell::Udp::endpoint listen_address(boost::asio::io_context& io, const Options& options,
                                    const std::vector<Contact>& join);

/// Where a peer that listens there can be reached, as far as this machine knows: of each network interface that is up,
/// addresses of one host, or `local` alone if it names one; kMostOwnAddresses at most, those of IPv4 first.
std::vector<Endpoint> own_addresses(const Endpoint& local);

}  // namespace padr::peer
