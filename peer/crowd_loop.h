#pragma once

#include <utility>  // Boost.Asio 1.74 uses std::exchange without including this

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <optional>
#include <string>

#include "common/crowd/crowd_peer.h"
#include "common/scenarios/input.h"
#include "peer/crowd_summary.h"
#include "peer/egress.h"
#include "peer/lateness.h"
#include "peer/log.h"
#include "peer/options.h"
#include "peer/packet_log.h"
#include "tools/support/clock.h"
#include "tools/support/files.h"
#include "tools/support/udp_socket.h"

namespace padr::peer {

/// What EventLoop is for a session, for a peer of a crowd: one thread, one socket, one timer.
class CrowdLoop {
 public:
  /// Resolves the addresses and opens the socket. Throws UserError or std::system_error. All must outlive it.
  CrowdLoop(const Options& options, Log& log, const support::Clock& clock);

  /// Until the end; the exit code. Throws only what the operating system refuses.
  int run();

 private:
  void shape_links();
  void open_files();
  void make_peer(const std::optional<Endpoint>& contact);
  void receive(const Endpoint& from, std::span<const std::byte> datagram);
  void send(const Endpoint& to, std::span<const std::byte> datagram);
  void flush();
  void wake();
  void advance(Micros now);
  void turn(Micros now);
  void tell();
  void note_playing(Micros now);
  void leave(const std::string& why, Micros now);
  void end_if_over(Micros now);
  void say_status(Micros now);
  void set_timer(Micros now);
  void on_signal(int signal);
  void end(int code, const std::string& reason);
  void write_summary();

  const Options& options_;
  Log& log_;
  const support::Clock& clock_;
  boost::asio::io_context io_;
  boost::asio::signal_set signals_;
  boost::asio::steady_timer timer_;
  std::optional<Micros> timer_due_;
  std::unique_ptr<support::OutputFile> json_;  ///< null for standard output, too
  std::unique_ptr<support::UdpSocket> socket_;
  std::unique_ptr<PacketLog> packets_;  ///< null: none is kept
  std::unique_ptr<Egress> egress_;
  std::unique_ptr<crowd::CrowdPeer> peer_;
  std::unique_ptr<scenarios::InputSource> input_;
  CrowdRecord record_;
  RateLimit net_limit_;
  Micros next_status_ = -1;  ///< local time; -1: not yet playing
  std::uint64_t told_bytes_ = 0;
  Micros told_at_ = 0;
  std::optional<Micros> left_at_;
  std::optional<Micros> drain_until_;
  bool stopping_ = false;
};

}  // namespace padr::peer
