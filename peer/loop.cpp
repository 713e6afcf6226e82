#include "peer/loop.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "common/model/user_error.h"
#include "peer/addresses.h"
#include "shell/netem_flags.h"
#include "shell/run_main.h"
#include "shell/stop_signals.h"

namespace padr::peer {
namespace {

/// After the end, datagrams that wait in the impaired links get this long to leave.
constexpr Micros kDrain = 300'000;

/// Addresses that are remembered as such that nothing can be sent to.
constexpr std::size_t kMostUnsendable = 256;
/// Where some datagrams can be sent and some cannot, that is said so often at most.
constexpr Micros kSayAgain = 60 * kMicrosPerSecond;

}  // namespace

Loop::Loop(const Options& options, Log& log, const shell::Clock& clock)
    : options_(options), log_(log), clock_(clock), io_(1), signals_(io_), timer_(io_) {
  shell::add_stop_signals(signals_);
  join_ = look_up_whom_to_join();
  socket_ = std::make_unique<shell::UdpSocket>(io_, listen_address(io_, options, join_));
  local_ = shell::to_endpoint(socket_->local());
  if (options.map_port) map_port();
}

// A machine that boots may start a peer before it has its network.
std::vector<Contact> Loop::look_up_whom_to_join() {
  const Micros patience = in_micros(options_.join_timeout);
  Micros said = -kSayAgain;
  for (const Micros begin = clock_.now();;) {
    try {
      return join_addresses(io_, options_);
    } catch (const shell::NotResolvedYet& e) {
      const Micros after = clock_.now() - begin;
      if (patience > 0 && after >= patience) throw;
      if (clock_.now() - said >= kSayAgain) {
        log_.net->warn("{}; trying on", e.what());
        said = clock_.now();
      }
    }
    wait_for_a_second();
  }
}

void Loop::wait_for_a_second() {
  std::string_view signal;
  signals_.async_wait([&](const boost::system::error_code& error, int number) {
    if (!error) signal = shell::name_of_signal(number);
  });
  io_.run_for(std::chrono::seconds(1));
  signals_.cancel();
  io_.restart();
  io_.poll();
  io_.restart();
  if (!signal.empty()) throw std::runtime_error(std::string(signal) + " before the session started");
}

void Loop::map_port() {
  const std::string port = std::to_string(local_.port);
  if (local_.is_loopback()) throw UserError("--map-port: --listen is a loopback address; give 0.0.0.0:PORT");
  const auto& bound = socket_->local().address();
  if (bound.is_v6() && !bound.is_unspecified())
    throw UserError("--map-port: routers map ports of IPv4, and --listen is an IPv6 address; give [::]:PORT");
  mapping_ = std::make_unique<PortMapping>(
      local_.port, [this, port] { log_.net->warn("the router no longer renews the mapping of port {}", port); });
  if (const auto& at = mapping_->outside())
    log_.net->info("the router forwards {} to this peer, by {}", to_string(*at), mapping_->protocol());
  else
    log_.net->warn(
        "no router maps ports here, by NAT-PMP or UPnP: peers outside can ask this one only if UDP port {} "
        "is forwarded to it otherwise",
        port);
}

std::vector<std::string> Loop::shape_links() {
  Egress::Specs specs;
  specs.all = options_.netem;
  specs.seed = options_.netem_seed;
  std::vector<std::string> lines{"links out: " + shell::describe(specs.all) + ", seed " + std::to_string(specs.seed)};
  for (const NetemOverride& n : options_.netem_to) {
    std::string where = "peer " + std::to_string(n.peer.value_or(0));
    if (n.peer) {
      specs.by_peer[*n.peer] = n.spec;
    } else {
      const shell::Udp::endpoint own = socket_->local();
      const Endpoint to = shell::to_endpoint(shell::resolve(io_, "--netem-to", *n.address, &own));
      specs.by_address[to] = n.spec;
      where = to_string(to);
    }
    lines.push_back("link to " + where + ": " + shell::describe(n.spec));
  }
  egress_ = std::make_unique<Egress>(std::move(specs), [this](const Endpoint& to, std::span<const std::byte> bytes) {
    if (!cuts_.is_cut_out(to)) socket_->post(to, bytes);
  });
  return lines;
}

void Loop::open_files() {
  if (!options_.pcap.empty()) packets_ = std::make_unique<PacketLog>(options_, *socket_);
  if (!options_.json.empty()) json_ = std::make_unique<shell::OutputFile>("--json", options_.json);
}

void Loop::say_where(const std::vector<std::string>& links) {
  log_.net->info("listening on {}", to_string(local_));
  for (const std::string& line : links) log_.net->info("{}", line);
}

int Loop::run() {
  start();
  wake();
  io_.run();
  log_.session->log(exit_code_ == 0 ? spdlog::level::info : spdlog::level::err, "ended: {}", reason_);
  finish();
  return exit_code_;
}

void Loop::start() {
  socket_->start([this](const Endpoint& from, std::span<const std::byte> bytes) { take(from, bytes); },
                 [this](const Endpoint& at) { unreachable(at, clock_.now()); }, [this] { wake(); });
  await_signal();
}

void Loop::finish() {
  const auto close_packets = [this] {
    if (!packets_) return;
    packets_->close();
    if (packets_->dropped() > 0)
      log_.net->error("--pcap: the file lacks {} datagrams, because the disk was too slow", packets_->dropped());
  };
  shell::do_all({[&] { or_fail(close_packets); }, [this] { or_fail([this] { write_summary(); }); }});
}

void Loop::or_fail(const std::function<void()>& step) {
  try {
    step();
  } catch (const std::exception& e) {
    if (std::exchange(step_failed_, true)) log_.session->error("{}", e.what());  // only the first is told by main()
    if (exit_code_ == shell::kExitFine) reason_ = e.what();
    exit_code_ = shell::kExitFailure;
    throw;
  }
}

void Loop::take(const Endpoint& from, std::span<const std::byte> datagram) {
  if (cuts_.is_cut_in(from)) return;
  if (packets_) packets_->received(from, datagram, PacketLog::now());
  if (!ending()) receive(from, datagram, clock_.now());
}

void Loop::flush() {
  // Before it goes: nobody must seem to have received it earlier.
  const std::int64_t time = packets_ ? PacketLog::now() : 0;
  socket_->flush([this, time](const Endpoint& to, std::span<const std::byte> datagram, bool sent) {
    if (sent) {
      if (packets_) packets_->sent(to, datagram, time);
      if (const auto it = unsendable_.find(to); it != unsendable_.end() && clock_.now() - it->second >= kSayAgain)
        unsendable_.erase(it);
    } else if (unsendable_.size() < kMostUnsendable && !unsendable_.contains(to) && net_limit_.pass(clock_.now())) {
      unsendable_[to] = clock_.now();
      log_.net->warn("cannot send to {}: {}; this is said once, until it is possible", to_string(to),
                     socket_->last_error());
    }
  });
}

void Loop::wake() {
  const Micros now = clock_.now();
  if (!ending()) advance(now);
  egress_->pump(now);
  flush();
  if (packets_ && packets_failure_.empty()) {
    packets_failure_ = packets_->failure();
    if (!packets_failure_.empty()) log_.net->error("--pcap: {}: nothing more is captured", packets_failure_);
  }
  if (ending() && (!egress_->next_due() || now >= *drain_until_)) {
    io_.stop();
    return;
  }
  set_timer(now);
}

bool Loop::is_time_for_status(Micros since, Micros now) {
  if (options_.status_interval <= 0) return false;
  const Micros interval = std::max<Micros>(in_micros(options_.status_interval), 1);
  if (next_status_ < 0) next_status_ = since + interval;
  if (now < next_status_) return false;
  // After a pause no sooner than half an interval from now: what a peer that catches up sends within a millisecond is
  // no rate.
  next_status_ += interval * ((now - next_status_ + interval / 2) / interval + 1);
  return true;
}

void Loop::set_timer(Micros now) {
  Micros due = ending() ? *drain_until_ : next_due();
  if (const auto next = egress_->next_due()) due = std::min(due, *next);
  due = std::max(due, now);
  if (due == timer_due_) return;  // datagrams that came in between seldom change it
  timer_due_ = due;
  timer_.expires_at(clock_.at(due));
  timer_.async_wait(shell::KeptIn(timer_memory_, [this](const boost::system::error_code& error) {
    if (error) return;
    timer_due_.reset();
    wake();
  }));
}

void Loop::await_signal() {
  signals_.async_wait([this](const boost::system::error_code& error, int signal) {
    if (!error) on_signal(std::string(shell::name_of_signal(signal)));
  });
}

void Loop::on_signal(const std::string& name) {
  if (stopping_ || ending()) {
    exit_code_ = shell::kExitFailure;
    reason_ = "quit at once on a second " + name;
    io_.stop();
    return;
  }
  stopping_ = true;
  await_signal();
  stop(name, clock_.now());
  wake();
}

void Loop::end(int code, const std::string& reason) {
  exit_code_ = code;
  reason_ = reason;
  drain_until_ = clock_.now() + kDrain;
}

void Loop::write_summary() {
  if (options_.json.empty()) return;
  json_->write(summary_text());
  json_->close();
}

}  // namespace padr::peer
