#pragma once

#include <utility>  // Boost.Asio 1.74 uses std::exchange without including this

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "peer/addresses.h"
#include "peer/egress.h"
#include "peer/link_cuts.h"
#include "peer/log.h"
#include "peer/options.h"
#include "peer/packet_log.h"
#include "peer/port_mapping.h"
#include "shell/clock.h"
#include "shell/files.h"
#include "shell/handler_memory.h"
#include "shell/udp_socket.h"

namespace padr::peer {

/// One thread, one socket, one timer, from the first datagram to the summary. Every time something happens, everything
/// is brought up to one `now`, and the timer is set to whatever is due first. What is played there, and with whom, is
/// up to the class derived from it.
class Loop {
 public:
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;
  virtual ~Loop() = default;

  /// Until the end; the exit code. Throws only what the operating system refuses (a full disk, say).
  int run();

 protected:
  /// Resolves the addresses and opens the socket. Throws UserError or std::system_error. All must outlive it; `clock`
  /// has run since the process began.
  Loop(const Options& options, Log& log, const shell::Clock& clock);

  /// Lines that tell of them, for say_where.
  std::vector<std::string> shape_links();
  /// Only once the port is ours: whoever has it may be writing to these very files.
  void open_files();
  void say_where(const std::vector<std::string>& links);
  /// Whether to say how things stand, when it has been playing since `since`.
  bool is_time_for_status(Micros since, Micros now);
  bool ending() const { return drain_until_.has_value(); }

  /// Something may have happened.
  void wake();

  // Where there is a body here, an override adds to it.

  virtual void start();
  virtual void receive(const Endpoint& from, std::span<const std::byte> datagram, Micros now) = 0;
  virtual void unreachable(const Endpoint& at, Micros now) = 0;
  /// Everything up to `now`, and what is to be sent into the links.
  virtual void advance(Micros now) = 0;
  virtual Micros next_due() const = 0;
  /// The first signal has come.
  virtual void stop(const std::string& signal, Micros now) = 0;
  /// All is over, but for what still is in the links.
  virtual void end(int code, const std::string& reason);
  /// Nothing comes or goes any more: files are completed.
  virtual void finish();
  virtual std::string summary_text() const = 0;
  /// Does this step of finish(). If it throws, the exit code and the reason say so in the summary.
  void or_fail(const std::function<void()>& step);

  const Options& options_;
  Log& log_;
  const shell::Clock& clock_;
  boost::asio::io_context io_;
  std::vector<Contact> join_;  ///< by whom, in turn; nobody: it founds
  std::unique_ptr<shell::UdpSocket> socket_;
  std::unique_ptr<PortMapping> mapping_;  ///< null: not asked for
  Endpoint local_;
  std::unique_ptr<Egress> egress_;
  LinkCuts cuts_;
  bool stopping_ = false;
  int exit_code_ = 0;
  std::string reason_;

 private:
  void map_port();
  /// Tries on until a name server answers, for as long as joining may take. Throws UserError.
  std::vector<Contact> look_up_whom_to_join();
  /// Throws std::runtime_error if a signal comes meanwhile.
  void wait_for_a_second();
  void flush();
  void take(const Endpoint& from, std::span<const std::byte> datagram);
  void set_timer(Micros now);
  void await_signal();
  void on_signal(const std::string& name);
  void write_summary();

  boost::asio::signal_set signals_;
  boost::asio::steady_timer timer_;
  std::shared_ptr<shell::HandlerMemory> timer_memory_ = std::make_shared<shell::HandlerMemory>();
  std::optional<Micros> timer_due_;  ///< what it is set to; nothing: it is not
  std::unique_ptr<shell::OutputFile> json_;
  std::string packets_failure_;            ///< as it was said; empty: none
  std::unique_ptr<PacketLog> packets_;     ///< null: none is kept
  std::map<Endpoint, Micros> unsendable_;  ///< the system has refused to send there, and when it was said
  RateLimit net_limit_;
  Micros next_status_ = -1;            ///< local time; -1: not yet playing
  bool step_failed_ = false;           ///< of those after the end
  std::optional<Micros> drain_until_;  ///< set at the end: what still is in the links may go until then
};

}  // namespace padr::peer
