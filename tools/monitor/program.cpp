#include "tools/monitor/program.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>

#include "common/model/user_error.h"
#include "shell/clock.h"
#include "shell/run_main.h"
#include "shell/stop_signals.h"
#include "shell/udp_socket.h"
#include "shell/unpredictable.h"
#include "tools/monitor/capture_film.h"
#include "tools/monitor/live.h"
#include "tools/monitor/lobby.h"
#include "tools/monitor/projector.h"
#include "tools/monitor/trace_film.h"
#include "tools/monitor/web_server.h"

namespace padr::monitor {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

/// What is due is looked after so often.
constexpr std::chrono::microseconds kTurn{kMicrosPerSecond / kTicksPerSecond};
/// For saying goodbye to pages.
constexpr std::chrono::milliseconds kGoodbye{300};

asio::ip::udp::endpoint address(asio::io_context& io, const char* flag, const shell::HostPort& where, bool insecure) {
  auto found = shell::resolve(io, flag, where);
  if (!found.address().is_loopback() && !insecure)
    throw UserError(std::string(flag) + ": '" + where.text +
                    "' can be reached from other machines, and nothing proves who sends; give a loopback address, or "
                    "--insecure if you trust the network");
  return found;
}

/// Opens what listens; says which flag changes a port that is taken.
template <typename Open>
auto open_at(const char* flag, const Open& open) {
  try {
    return open();
  } catch (const std::system_error& e) {
    if (e.code() != std::errc::address_in_use) throw;
    throw std::runtime_error(std::string(e.what()) + "; give another port with " + flag + " (0: any free port)");
  }
}

/// The loop around everything: sockets, timers, signals.
class Program {
 public:
  explicit Program(const Options& options) : options_(options), signals_(io_), turn_(io_), end_(io_) {}
  ~Program() {
    if (web_) web_->stop();
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  int run() {
    // What is wrong with an address is said before anything is opened.
    const auto web = address(io_, "--listen", options_.listen, options_.insecure);
    if (options_.traces.empty() && options_.captures.empty()) {
      open_peers(address(io_, "--peers-listen", options_.peers, options_.insecure));
    } else {
      open_recording();
    }
    open_web({web.address(), web.port()});
    if (peers_) spdlog::info("peers tell it at --monitor {}", to_string(shell::to_endpoint(peers_->local())));
    shell::add_stop_signals(signals_);
    signals_.async_wait([this](const error_code& error, int) {
      if (!error) stop();
    });
    if (options_.duration > 0) {
      end_.expires_after(std::chrono::microseconds(static_cast<std::int64_t>(options_.duration * 1e6)));
      end_.async_wait([this](const error_code& error) {
        if (!error) stop();
      });
    }
    turn_.expires_after(kTurn);
    turn();
    io_.run();
    return shell::kExitFine;
  }

 private:
  void open_peers(const shell::Udp::endpoint& where) {
    peers_ = open_at("--peers-listen", [&] { return std::make_unique<shell::UdpSocket>(io_, where); });
    const Endpoint at = shell::to_endpoint(peers_->local());
    auto live = std::make_unique<Live>(
        options_, to_string(at), shell::unpredictable() | 1U,
        [this](const Endpoint& to, const Bytes& datagram) { peers_->send(to, datagram); },
        [](const std::string& line) { spdlog::info("{}", line); });
    peers_->start([this, l = live.get()](const Endpoint& from,
                                         std::span<const std::byte> d) { l->receive(from, d, clock_.now()); },
                  [](const Endpoint&) {}, [] {});
    lobby_ = std::make_unique<Lobby>(options_, std::move(live));
  }

  /// Signals end the program as they end any other until it is read.
  void open_recording() {
    const Note note = [](const std::string& line) { spdlog::info("{}", line); };
    const bool traces = !options_.traces.empty();
    Film film = traces ? film_traces(options_.traces, note)
                       : film_captures(options_.captures, options_.keylogs, options_.setting, note);
    if (film.moments.empty())
      throw UserError(std::string(traces ? "--trace" : "--capture") + ": there is nothing to show");
    const auto& played = traces ? options_.traces : options_.captures;
    std::string source = played.front();
    if (played.size() > 1) source += " and " + std::to_string(played.size() - 1) + " more";
    note("plays ticks " + std::to_string(film.first()) + " to " + std::to_string(film.last()) + " of " + source);
    lobby_ = std::make_unique<Lobby>(
        options_, std::make_unique<Projector>(options_, traces ? "trace" : "capture", source, std::move(film)));
  }

  void open_web(const WebServer::Tcp::endpoint& where) {
    web_ = open_at("--listen",
                   [&] { return std::make_shared<WebServer>(io_, where, options_.names, WebLimits{}, *lobby_); });
    lobby_->connect(web_.get());
    web_->start();
    const auto local = web_->local();
    const std::string host =
        local.address().is_v6() ? "[" + local.address().to_string() + "]" : local.address().to_string();
    std::printf("http://%s:%d/\n", host.c_str(), int{local.port()});
    std::fflush(stdout);
  }

  void turn() {
    turn_.async_wait([this](const error_code& error) {
      if (error) return;
      lobby_->advance(clock_.now());
      // On absolute deadlines; after having been held up, from now on.
      turn_.expires_at(std::max(turn_.expiry() + kTurn, asio::steady_timer::clock_type::now()));
      turn();
    });
  }

  void stop() {
    turn_.cancel();
    if (peers_) peers_->close();
    lobby_->connect(nullptr);
    web_->stop();
    end_.expires_after(kGoodbye);
    end_.async_wait([this](const error_code&) { io_.stop(); });
  }

  const Options& options_;
  shell::Clock clock_;
  asio::io_context io_{1};
  asio::signal_set signals_;
  asio::steady_timer turn_;
  asio::steady_timer end_;
  std::unique_ptr<shell::UdpSocket> peers_;
  std::unique_ptr<Lobby> lobby_;
  std::shared_ptr<WebServer> web_;  ///< connections keep it longer, but do not call the lobby after stop()
};

}  // namespace

int run(const Options& options) {
  const auto logger = spdlog::stderr_logger_st("padr-monitor");
  logger->set_pattern("%Y-%m-%dT%H:%M:%S.%e %l %v");
  spdlog::set_default_logger(logger);
  return Program(options).run();
}

}  // namespace padr::monitor
