#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/monitor/codec.h"
#include "common/monitor/sampler.h"
#include "peer/egress.h"
#include "peer/link_cuts.h"
#include "peer/log.h"
#include "peer/options.h"
#include "peer/player.h"
#include "peer/watcher.h"
#include "shell/clock.h"
#include "shell/udp_socket.h"

namespace padr::peer {

/// What became of what was told, and of what was ordered.
struct TellerStats {
  std::uint64_t datagrams = 0;
  std::uint64_t bytes = 0;
  std::uint64_t untold = 0;    ///< datagrams that the system would not take
  std::uint64_t orders = 0;    ///< taken
  std::uint64_t rejected = 0;  ///< came, but are no orders, or not from whom we tell, or not new
};

/// --monitor: tells a monitor what this peer sees, through a socket of its own, and hands on what the monitor orders
/// if --control allows it. Never waits for anything: what the system does not take at once is not told. Whether
/// anybody listens makes no difference.
class Telemetry final : public Watcher {
 public:
  using Obey = std::function<void(const monitor::Order&)>;

  /// Opens the socket, if the address is known already. Throws UserError if orders must not be taken from there, or
  /// std::system_error. All must outlive it.
  Telemetry(boost::asio::io_context& io, const Options& options, Log& log, const shell::Clock& clock);
  /// `obey`: for every order that counts; `afterwards`: some may have come.
  void start(Obey obey, std::function<void()> afterwards);
  /// Nothing comes any more, and nothing holds up the end of the program's loop.
  void close();

  // As Watcher.
  void begun(const node::Replica& replica, int incarnation) override;
  void stepped(const Step& step) override;
  void confirmed(int incarnation, const sync::FoldState& state, std::uint64_t hash) override;
  void changed(const node::MemberChange& change) override { sampler_.observe(change); }

  /// Something that only the shell knows of; the number is filled in.
  void say(monitor::Event event) { sampler_.say(std::move(event)); }
  /// An order of this number drives the avatar, or lets go of it.
  void drives(std::uint32_t order) { drive_order_ = order; }

  struct Situation {
    const Player& player;
    const Egress& egress;
    const LinkCuts& cuts;
    Endpoint at;  ///< where the session's socket listens
  };
  /// Tells what is due besides frames.
  void update(const Situation& s, Micros now);
  Micros next_due() const { return next_; }
  /// The last word.
  void end(const Situation& s, const std::string& reason, Micros now);

  const TellerStats& stats() const { return stats_; }

 private:
  void resolve_again();
  void found(const shell::Udp::endpoint& where);
  bool listened_to() const { return socket_ && clock_.now() >= nobody_until_; }
  void receive(const Endpoint& from, std::span<const std::byte> datagram);
  void send(const monitor::Message& message);
  void tell_hello(const Situation& s);
  void tell_scenario();
  void tell_status(const Situation& s);
  void tell_news(bool again);

  const Options& options_;
  Log& log_;
  const shell::Clock& clock_;
  boost::asio::io_context& io_;
  std::unique_ptr<shell::UdpSocket> socket_;
  shell::Udp::resolver resolver_;
  std::optional<Endpoint> to_;  ///< absent as long as its name is unknown
  bool obeys_ = false;          ///< what comes from there
  Micros nobody_until_ = 0;     ///< nobody listens there, as far as is known
  Obey obey_;
  std::function<void()> afterwards_;
  monitor::Sampler sampler_;
  monitor::Origin from_;
  std::uint64_t token_ = 0;
  std::uint64_t issuer_ = 0;  ///< of the orders that came last
  std::uint32_t taken_ = 0;   ///< number of the newest of them
  int incarnation_ = -1;
  bool driven_ = false;
  std::uint32_t drive_order_ = 0;
  int agreed_told_ = 0;  ///< since the last step
  Micros next_ = 0;
  int beat_ = 0;
  std::size_t scenario_at_ = 0;  ///< where the next piece of its text begins
  std::deque<monitor::Event> news_;
  monitor::Frame frame_;  ///< kept for its memory, as is the next one
  monitor::Agreed agreed_;
  TellerStats stats_;
};

}  // namespace padr::peer
