#include "peer/udp_socket.h"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <system_error>

#include "common/model/user_error.h"

namespace padr::peer {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

/// Datagrams read in one go before timers get their turn.
constexpr int kReadsPerWakeUp = 64;
/// Bursts must survive until the loop gets to them.
constexpr int kReceiveBufferBytes = 1 << 20;

Udp::endpoint to_asio(const Endpoint& e, bool v4) {
  if (v4) {
    asio::ip::address_v4::bytes_type bytes{};
    std::copy(e.address.begin() + 12, e.address.end(), bytes.begin());
    return {asio::ip::address_v4(bytes), e.port};
  }
  return {asio::ip::address_v6(e.address), e.port};
}

}  // namespace

Udp::endpoint resolve(asio::io_context& io, const std::string& flag, const support::HostPort& where,
                      const Udp* family) {
  Udp::resolver resolver(io);
  error_code error;
  const auto found = resolver.resolve(where.host, std::to_string(where.port), error);
  if (error || found.empty())
    throw UserError(flag + ": cannot resolve '" + where.host + "': " + (error ? error.message() : "no address"));
  const Udp wanted = family != nullptr ? *family : Udp::v4();
  for (const auto& entry : found)
    if (entry.endpoint().protocol() == wanted) return entry.endpoint();
  if (family == nullptr) return found.begin()->endpoint();
  throw UserError(flag + ": '" + where.host + "' has no " + (wanted == Udp::v4() ? "IPv4" : "IPv6") +
                  " address, and the own address, --listen, is of that kind");
}

Endpoint to_endpoint(const Udp::endpoint& e) {
  Endpoint out;
  out.port = e.port();
  const auto address = e.address();
  out.address = address.is_v6() ? address.to_v6().to_bytes()
                                : asio::ip::make_address_v6(asio::ip::v4_mapped, address.to_v4()).to_bytes();
  return out;
}

UdpSocket::UdpSocket(asio::io_context& io, const Udp::endpoint& address) : socket_(io), v4_(address.address().is_v4()) {
  error_code error;
  socket_.open(address.protocol(), error);
  // [::] shall reach IPv4 peers too.
  if (!error && !v4_) socket_.set_option(asio::ip::v6_only(!address.address().is_unspecified()), error);
  if (!error) socket_.bind(address, error);
  if (!error) socket_.non_blocking(true, error);
  if (error) throw std::system_error(error, "cannot listen on " + to_string(to_endpoint(address)));
  error_code ignored;  // the system's default will do
  socket_.set_option(asio::socket_base::receive_buffer_size(kReceiveBufferBytes), ignored);
}

void UdpSocket::start(Receiver each, std::function<void()> afterwards) {
  each_ = std::move(each);
  afterwards_ = std::move(afterwards);
  wait();
}

void UdpSocket::close() {
  error_code ignored;
  socket_.close(ignored);
}

void UdpSocket::wait() {
  socket_.async_wait(Udp::socket::wait_read, [this](const error_code& error) {
    if (error == asio::error::operation_aborted || !socket_.is_open()) return;
    read();
    afterwards_();
    if (socket_.is_open()) wait();
  });
}

void UdpSocket::read() {
  for (int i = 0; i < kReadsPerWakeUp && socket_.is_open(); ++i) {
    Udp::endpoint from;
    error_code error;
    const std::size_t size = socket_.receive_from(asio::buffer(buffer_), from, 0, error);
    if (error == asio::error::would_block) return;
    if (error == asio::error::connection_refused) {
      ++stats_.refused;
    } else if (error) {
      ++stats_.receive_errors;
      last_error_ = error.message();
    } else {
      each_(to_endpoint(from), std::span(buffer_).first(size));
    }
  }
}

Endpoint UdpSocket::local_towards(const Endpoint& to) const {
  Endpoint own = to_endpoint(local());
  if (v4_ && !to.is_v4()) return own;
  // Connecting a UDP socket sends nothing, but lets the system choose an address.
  asio::io_context io(1);
  const Udp::endpoint where = to_asio(to, to.is_v4());
  Udp::socket probe(io);
  error_code error;
  probe.open(where.protocol(), error);
  if (!error) probe.connect(where, error);
  if (!error) own.address = to_endpoint(probe.local_endpoint(error)).address;
  return own;
}

bool UdpSocket::send(const Endpoint& to, std::span<const std::byte> datagram) {
  error_code error;
  if (v4_ && !to.is_v4()) {
    error = asio::error::address_family_not_supported;
  } else {
    const Udp::endpoint where = to_asio(to, v4_);
    const auto bytes = asio::buffer(datagram.data(), datagram.size());
    socket_.send_to(bytes, where, 0, error);
    if (error == asio::error::connection_refused) {
      // News about an earlier datagram, which kept this one from being sent.
      ++stats_.refused;
      socket_.send_to(bytes, where, 0, error);
    }
  }
  if (!error) {
    ++stats_.sent;
    return true;
  }
  const bool full = error == asio::error::would_block || error == asio::error::no_buffer_space;
  ++(full ? stats_.buffer_full : stats_.send_errors);
  last_error_ = error.message();
  return false;
}

}  // namespace padr::peer
