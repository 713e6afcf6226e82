#pragma once

#include <utility>  // Boost.Asio 1.74 uses std::exchange without including this

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "peer/controls.h"
#include "peer/cuts.h"
#include "peer/egress.h"
#include "peer/health.h"
#include "peer/log.h"
#include "peer/options.h"
#include "peer/packet_log.h"
#include "peer/player.h"
#include "peer/recordings.h"
#include "peer/session_key.h"
#include "peer/status.h"
#include "peer/teller.h"
#include "tools/support/clock.h"
#include "tools/support/files.h"
#include "tools/support/udp_socket.h"

namespace padr::peer {

/// One thread, one socket, one timer: comes together with the others, plays, leaves. Every time something happens,
/// everything is brought up to one `now`, and the timer is set to whatever is due first.
class EventLoop {
 public:
  /// Resolves the addresses and opens the socket. Throws UserError or std::system_error.
  /// `clock` has run since the process began.
  EventLoop(const Options& options, Log& log, const support::Clock& clock);

  /// Until the end; the exit code. Throws only what the operating system refuses (a full disk, say).
  int run();

 private:
  /// What is to be said of it, once all is well.
  std::vector<std::string> shape_links();
  void open_files();
  void wake();
  void send(const Endpoint& to, std::span<const std::byte> datagram);
  void flush();
  void receive(const Endpoint& from, std::span<const std::byte> datagram);
  void advance(Micros now);
  void send_out(Micros now);
  void end_if_over(Micros now);
  void say_status(Micros now);
  void set_timer(Micros now);
  void on_signal(int signal);
  void end(int code, const std::string& reason);
  void write_summary();
  Teller::Situation situation() const { return {*player_, *egress_, cuts_, local_}; }

  const Options& options_;
  Log& log_;
  const support::Clock& clock_;
  boost::asio::io_context io_;
  boost::asio::signal_set signals_;
  boost::asio::steady_timer timer_;
  std::optional<Micros> timer_due_;  ///< what it is set to; nothing: it is not
  std::unique_ptr<Recordings> recordings_;
  std::unique_ptr<Keylog> keylog_;             ///< null if nobody asked for it
  std::unique_ptr<Health> health_;             ///< null if nobody asked for it
  std::unique_ptr<support::OutputFile> json_;  ///< null for standard output, too
  std::unique_ptr<support::UdpSocket> socket_;
  std::unique_ptr<PacketLog> packets_;  ///< null: none is kept
  std::unique_ptr<Egress> egress_;
  Cuts cuts_;
  std::unique_ptr<Teller> teller_;  ///< null: there is no monitor
  std::unique_ptr<Player> player_;
  std::unique_ptr<Controls> controls_;  ///< null: nobody orders anything
  Endpoint local_;
  Status status_;
  Micros next_status_ = -1;  ///< local time; -1: not yet playing
  RateLimit net_limit_;
  bool stopping_ = false;
  std::optional<Micros> drain_until_;  ///< set at the end: what still is in the links may go until then
  int exit_code_ = 0;
  std::string reason_;
};

}  // namespace padr::peer
