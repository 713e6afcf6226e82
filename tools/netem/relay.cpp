#include "tools/netem/relay.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <boost/asio/buffer.hpp>
#include <span>
#include <system_error>

#include "common/model/rng.h"
#include "common/model/user_error.h"

namespace padr::netem {

namespace {

namespace asio = boost::asio;
using Udp = asio::ip::udp;
using boost::system::error_code;

/// Datagrams read in one go before timers get their turn.
constexpr int kReadsPerWakeUp = 64;
/// Bursts must survive until the loop gets to them; what the kernel drops here no statistics can show.
constexpr int kReceiveBufferBytes = 1 << 20;

std::string text_of(const Udp::endpoint& e) {
  const std::string address = e.address().to_string();
  return (e.address().is_v6() ? "[" + address + "]" : address) + ":" + std::to_string(e.port());
}

/// The first address of the wanted family (the listener's, so that `localhost` means the same on both sides), else the
/// first of any.
Udp::endpoint resolve(asio::io_context& io, const HostPort& where, const Udp::endpoint* like) {
  Udp::resolver resolver(io);
  error_code error;
  const auto found = resolver.resolve(where.host, std::to_string(where.port), error);
  if (error || found.empty()) {
    throw UserError("--link: cannot resolve \"" + where.host + "\": " + (error ? error.message() : "no address"));
  }
  for (const auto& entry : found) {
    const bool v4 = entry.endpoint().address().is_v4();
    if (like == nullptr ? v4 : v4 == like->address().is_v4()) return entry.endpoint();
  }
  return found.begin()->endpoint();
}

/// Whether what is sent there comes back to this machine: only such addresses can be bound.
bool is_own(asio::io_context& io, const asio::ip::address& address) {
  Udp::socket socket(io);
  error_code error;
  const Udp::endpoint any_port(address, 0);
  socket.open(any_port.protocol(), error);
  if (!error) socket.bind(any_port, error);
  return !error;
}

bool would_reach(asio::io_context& io, const Udp::endpoint& target, const Udp::endpoint& listener) {
  if (target.port() != listener.port()) return false;
  if (target == listener) return true;
  const bool v4_to_v6 = target.address().is_v4() && listener.address().is_v6();
  if (listener.address().is_unspecified())
    return (v4_to_v6 || target.protocol() == listener.protocol()) && is_own(io, target.address());
  return target.address().is_unspecified() && listener.address().is_loopback() &&
         target.protocol() == listener.protocol();
}

Udp::endpoint target_of(asio::io_context& io, const LinkOptions& link) {
  const Udp::endpoint listener = resolve(io, link.listen, nullptr);
  Udp::endpoint target = resolve(io, link.target, &listener);
  if (would_reach(io, target, listener))
    throw UserError("--link: \"" + link.listen.text + "=" + link.target.text + "\" would relay to itself");
  return target;
}

void set_buffer(Udp::socket& socket) {
  error_code ignored;  // the system's default will do
  socket.set_option(asio::socket_base::receive_buffer_size(kReceiveBufferBytes), ignored);
}

Udp::socket listen(asio::io_context& io, const HostPort& where) {
  const Udp::endpoint address = resolve(io, where, nullptr);
  Udp::socket socket(io);
  error_code error;
  socket.open(address.protocol(), error);
  if (!error) socket.bind(address, error);
  if (!error) socket.non_blocking(true, error);
  if (error) throw std::system_error(error, "cannot listen on " + where.text);
  set_buffer(socket);
  return socket;
}

void add(link::ShimStats& sum, const link::ShimStats& s) {
  sum.accepted += s.accepted;
  sum.released += s.released;
  sum.lost += s.lost;
  sum.duplicated += s.duplicated;
  sum.corrupted += s.corrupted;
  sum.reordered += s.reordered;
  sum.overlimit += s.overlimit;
  sum.accepted_bytes += s.accepted_bytes;
  sum.released_bytes += s.released_bytes;
}

std::string text_of(const link::ShimStats& s, std::size_t held) {
  return fmt::format("in {} out {} lost {} dup {} corrupt {} reordered {} overlimit {} held {} bytes {}", s.accepted,
                     s.released, s.lost, s.duplicated, s.corrupted, s.reordered, s.overlimit, held, s.released_bytes);
}

}  // namespace

struct Relay::Client {
  Client(asio::io_context& io, const LinkOptions& options, const Udp::endpoint& from, std::uint64_t seed)
      : address(from),
        upstream(io),
        timer(io),
        to_target(options.to_target, derive_seed(seed, 0)),
        to_client(options.to_client, derive_seed(seed, 1)) {}

  Udp::endpoint address;
  Udp::socket upstream;
  asio::steady_timer timer;
  std::optional<Micros> timer_at;
  link::Shim to_target;
  link::Shim to_client;
  Micros last_heard = 0;
};

Relay::Relay(asio::io_context& io, const Clock& clock, LinkOptions options, std::uint64_t seed, Limits limits)
    : io_(io),
      clock_(clock),
      options_(std::move(options)),
      seed_(seed),
      limits_(limits),
      target_(target_of(io, options_)),
      listening_(listen(io, options_.listen)) {}

Relay::~Relay() = default;

void Relay::start() {
  wait_for_clients();
}

bool Relay::leads_to(const Relay& other) const {
  return would_reach(io_, target_, other.listening_.local_endpoint());
}

std::string Relay::name() const {
  return text_of(listening_.local_endpoint()) + " -> " + text_of(target_);
}

// ---- from clients

void Relay::wait_for_clients() {
  listening_.async_wait(Udp::socket::wait_read, [this](const error_code& error) {
    if (error == asio::error::operation_aborted) return;
    read_clients();
    wait_for_clients();
  });
}

void Relay::read_clients() {
  const Micros now = clock_.now();
  for (int i = 0; i < kReadsPerWakeUp; ++i) {
    Udp::endpoint from;
    error_code error;
    const std::size_t size = listening_.receive_from(asio::buffer(buffer_), from, 0, error);
    if (error == asio::error::would_block) return;
    if (error) continue;  // an ICMP error about something sent earlier
    const auto client = client_at(from, now);
    if (!client) continue;
    client->to_target.accept(now, std::span(buffer_).first(size));
    pump(client, now);
  }
}

std::shared_ptr<Relay::Client> Relay::client_at(const Udp::endpoint& address, Micros now) {
  const auto known = clients_.find(address);
  auto client = known != clients_.end() ? known->second : add_client(address);
  if (client) client->last_heard = now;
  return client;
}

/// Null if there are too many clients or no socket can be had; both are counted, and logged the first time.
std::shared_ptr<Relay::Client> Relay::add_client(const Udp::endpoint& address) {
  error_code error;
  if (clients_.size() < limits_.max_clients) {
    auto client = std::make_shared<Client>(io_, options_, address, derive_seed(seed_, clients_ever_));
    client->upstream.open(target_.protocol(), error);
    if (!error) client->upstream.connect(target_, error);
    if (!error) client->upstream.non_blocking(true, error);
    if (!error) {
      set_buffer(client->upstream);
      ++clients_ever_;
      clients_.emplace(address, client);
      spdlog::info("{}: client {} joins through {}", name(), text_of(address),
                   text_of(client->upstream.local_endpoint()));
      wait_for_replies(client);
      return client;
    }
  }
  if (refused_++ == 0) {
    spdlog::warn("{}: datagram of new client {} ignored, {} (said once; counted as refused)", name(), text_of(address),
                 error ? error.message() : fmt::format("there are {} already", clients_.size()));
  }
  return nullptr;
}

// ---- from the target

void Relay::wait_for_replies(const std::shared_ptr<Client>& client) {
  client->upstream.async_wait(Udp::socket::wait_read, [this, client](const error_code& error) {
    if (error == asio::error::operation_aborted || !client->upstream.is_open()) return;
    read_replies(*client);
    pump(client, clock_.now());
    wait_for_replies(client);
  });
}

void Relay::read_replies(Client& client) {
  const Micros now = clock_.now();
  for (int i = 0; i < kReadsPerWakeUp; ++i) {
    error_code error;
    const std::size_t size = client.upstream.receive(asio::buffer(buffer_), 0, error);
    if (error == asio::error::would_block) return;
    if (error) continue;  // nobody listens at the target (ICMP); it may come up later
    client.last_heard = now;
    client.to_client.accept(now, std::span(buffer_).first(size));
  }
}

// ---- out

/// Sends everything that has come out of the client's two shims and sleeps until more can.
void Relay::pump(const std::shared_ptr<Client>& client, Micros now) {
  error_code error;
  while (const auto datagram = client->to_target.release(now)) {
    client->upstream.send(asio::buffer(*datagram), 0, error);
    // A refusal is news about an earlier datagram (nobody listened at the target) and keeps this one from being sent.
    if (error == asio::error::connection_refused) client->upstream.send(asio::buffer(*datagram), 0, error);
    count_send(error);
  }
  while (const auto datagram = client->to_client.release(now)) {
    listening_.send_to(asio::buffer(*datagram), client->address, 0, error);
    count_send(error);
  }
  set_timer(client);
}

void Relay::set_timer(const std::shared_ptr<Client>& client) {
  auto due = client->to_target.next_due();
  const auto back = client->to_client.next_due();
  if (back && (!due || *back < *due)) due = back;
  if (due == client->timer_at) return;
  client->timer_at = due;
  if (!due) {
    client->timer.cancel();
    return;
  }
  client->timer.expires_at(clock_.at(*due));
  client->timer.async_wait([this, client](const error_code& error) {
    if (error || !client->upstream.is_open()) return;
    client->timer_at.reset();
    pump(client, clock_.now());
  });
}

void Relay::count_send(const error_code& error) {
  if (error) ++send_errors_;
}

// ---- housekeeping

void Relay::forget_idle_clients() {
  const Micros now = clock_.now();
  for (auto it = clients_.begin(); it != clients_.end();) {
    Client& client = *it->second;
    const bool held = client.to_target.in_flight() != 0 || client.to_client.in_flight() != 0;
    if (held || now - client.last_heard < limits_.client_idle) {
      ++it;
      continue;
    }
    add(gone_.to_target, client.to_target.stats());
    add(gone_.to_client, client.to_client.stats());
    spdlog::info("{}: client {} is silent and forgotten", name(), text_of(client.address));
    error_code ignored;
    client.upstream.close(ignored);  // ends its handlers, which hold the last references
    it = clients_.erase(it);
  }
}

std::string Relay::stats_line() const {
  Totals sum = gone_;
  for (const auto& [address, client] : clients_) {
    add(sum.to_target, client->to_target.stats());
    add(sum.to_client, client->to_client.stats());
    sum.held_to_target += client->to_target.in_flight();
    sum.held_to_client += client->to_client.in_flight();
  }
  return fmt::format("{}: clients {} refused {} send-errors {} | there: {} | back: {}", name(), clients_.size(),
                     refused_, send_errors_, text_of(sum.to_target, sum.held_to_target),
                     text_of(sum.to_client, sum.held_to_client));
}

}  // namespace padr::netem
