#pragma once

#include <utility>  // Boost.Asio 1.74 uses std::exchange without including this

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/model/endpoint.h"
#include "common/model/user_error.h"
#include "shell/handler_memory.h"
#include "shell/host_port.h"

namespace padr::shell {

using Udp = boost::asio::ip::udp;

/// No name server has answered: it may a moment later.
struct NotResolvedYet : UserError {
  using UserError::UserError;
};

/// The first address of HOST that a socket at `own` can send to, of its family if there is one; without `own`, IPv4
/// before IPv6. Throws UserError, which names the flag, if there is none; NotResolvedYet if that may change.
Udp::endpoint resolve(boost::asio::io_context& io, const std::string& flag, const shell::HostPort& where,
                      const Udp::endpoint* own = nullptr);
/// All such addresses, that one first; of the other family none but to a socket of both.
std::vector<Udp::endpoint> resolve_all(boost::asio::io_context& io, const std::string& flag,
                                       const shell::HostPort& where, const Udp::endpoint* own = nullptr);

Endpoint to_endpoint(const Udp::endpoint& e);

/// What the socket could not do.
struct SocketStats {
  std::uint64_t sent = 0;
  std::uint64_t send_errors = 0;     ///< not sent for another reason than these
  std::uint64_t refused = 0;         ///< ICMP port unreachable: nobody listens where something was sent earlier
  std::uint64_t buffer_full = 0;     ///< not sent, the system's buffer was full
  std::uint64_t receive_errors = 0;  ///< besides refusals
};

/// A bound UDP socket that never gives up: errors are counted, none ends the reading.
class UdpSocket {
 public:
  using Refusal = std::function<void(const Endpoint& at)>;
  using Receiver = std::function<void(const Endpoint& from, std::span<const std::byte> datagram)>;

  /// Throws std::system_error if the address cannot be used.
  UdpSocket(boost::asio::io_context& io, const Udp::endpoint& address);

  /// From now on: `each` for every datagram, `refused` for every word that nobody listens where something was sent to
  /// which quotes what that was, `afterwards` after each batch of them.
  void start(Receiver each, Refusal refused, std::function<void()> afterwards);
  void close();

  /// False if it was not sent: see stats() and last_error().
  bool send(const Endpoint& to, std::span<const std::byte> datagram);

  /// For the next flush().
  void post(const Endpoint& to, std::span<const std::byte> datagram);
  /// Sends all that was posted, in that order, with as few calls of the system as it takes, and says of each whether it
  /// was sent; false as above.
  using Outcome = std::function<void(const Endpoint& to, std::span<const std::byte> datagram, bool sent)>;
  void flush(const Outcome& each);

  Udp::endpoint local() const { return socket_.local_endpoint(); }
  /// The address that the system would send from to there; where that cannot be told, the one that it is bound to.
  Endpoint local_towards(const Endpoint& to) const;
  const SocketStats& stats() const { return stats_; }
  std::string last_error() const { return last_error_; }

 private:
  void wait();
  void read();
  void read_refusals();
  std::size_t send_posted(std::size_t from);
  void take_refusal(const Endpoint& at, std::span<const std::byte> quoted);
  void remember(const Endpoint& to, std::span<const std::byte> datagram);

  std::shared_ptr<HandlerMemory> memory_ = std::make_shared<HandlerMemory>();  ///< for waiting
  Udp::socket socket_;
  bool v4_;
  Receiver each_;
  Refusal refused_;
  std::function<void()> afterwards_;
  SocketStats stats_;
  static constexpr std::size_t kQuoted = 32;  ///< bytes that nobody guesses who has not seen them
  struct Sent {
    Endpoint to;
    std::size_t size = 0;
    std::array<std::byte, kQuoted> begin{};
  };
  std::array<Sent, 64> sent_{};  ///< the latest
  std::size_t next_sent_ = 0;
  std::string last_error_;
  struct Posted {
    Endpoint to;
    Udp::endpoint where;
    std::size_t at = 0;  ///< in posted_bytes_
    std::size_t size = 0;
  };
  std::vector<Posted> posted_;
  std::vector<std::byte> posted_bytes_;
  static constexpr std::size_t kBatch = 32;        ///< datagrams read or sent by one call of the system
  static constexpr std::size_t kLongest = 65'536;  ///< larger than any UDP payload: nothing is cut short unnoticed
  /// kBatch * kLongest bytes, of which memory is used as far as datagrams have ever filled it.
  std::unique_ptr<std::byte[]> inbox_;
};

}  // namespace padr::shell
