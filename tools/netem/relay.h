#pragma once

#include <utility>  // Boost.Asio 1.74 uses std::exchange without including this

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "common/link/shim.h"
#include "common/model/ids.h"
#include "shell/clock.h"
#include "tools/netem/options.h"

namespace padr::netem {

using shell::Clock;

/// One --link: a socket that clients send to, and for each client a socket towards the target, so that replies find
/// their way back.
class Relay {
 public:
  struct Limits {
    std::size_t max_clients = 0;
    Micros client_idle = 0;
  };

  /// Resolves both addresses and opens the listening socket.
  /// Throws UserError if a name is unknown, std::system_error if the address cannot be used.
  Relay(boost::asio::io_context& io, const Clock& clock, LinkOptions options, std::uint64_t seed, Limits limits);
  ~Relay();
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  /// Begins to relay.
  void start();

  /// Whether what it relays comes to another relay's listening socket.
  bool leads_to(const Relay& other) const;

  /// Forgets clients that have been silent for too long.
  void forget_idle_clients();

  /// `LISTEN -> TARGET`, with the port that was really opened.
  std::string name() const;

  /// Both directions, clients gone included, in one line.
  std::string stats_line() const;

 private:
  using Udp = boost::asio::ip::udp;
  struct Client;
  /// Sums over clients, and what the sockets did.
  struct Totals {
    link::ShimStats to_target, to_client;
    std::size_t held_to_target = 0, held_to_client = 0;
  };

  void wait_for_clients();
  void read_clients();
  void wait_for_replies(const std::shared_ptr<Client>& client);
  void read_replies(Client& client);
  std::shared_ptr<Client> client_at(const Udp::endpoint& address, Micros now);
  std::shared_ptr<Client> add_client(const Udp::endpoint& address);
  void pump(const std::shared_ptr<Client>& client, Micros now);
  void set_timer(const std::shared_ptr<Client>& client);
  void count_send(const boost::system::error_code& error);

  boost::asio::io_context& io_;
  const Clock& clock_;
  LinkOptions options_;
  std::uint64_t seed_;
  Limits limits_;
  Udp::endpoint target_;
  Udp::socket listening_;
  std::map<Udp::endpoint, std::shared_ptr<Client>> clients_;
  std::uint64_t clients_ever_ = 0;
  Totals gone_;  ///< of clients forgotten
  std::uint64_t refused_ = 0;
  std::uint64_t send_errors_ = 0;
  std::array<std::byte, 65536> buffer_;  ///< larger than any UDP payload
};

}  // namespace padr::netem
