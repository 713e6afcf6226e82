#include "shell/udp_socket.h"

#include <linux/errqueue.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "common/model/user_error.h"

namespace padr::shell {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

/// Batches of datagrams, or pieces of news, read in one go before timers get their turn.
constexpr int kRoundsPerWakeUp = 4;
constexpr int kNewsPerWakeUp = 64;
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

/// Whether a socket there has to do with IPv4 alone, or IPv6 alone. [::] reaches IPv4 peers, too.
bool is_of_one_family(const Udp::endpoint& at) {
  return at.address().is_v4() || !at.address().is_unspecified();
}

/// An IPv4 address may be written as one of IPv6.
Udp::endpoint as_it_is(const Udp::endpoint& e) {
  if (!e.address().is_v6() || !e.address().to_v6().is_v4_mapped()) return e;
  return {asio::ip::make_address_v4(asio::ip::v4_mapped, e.address().to_v6()), e.port()};
}

}  // namespace

Udp::endpoint resolve(asio::io_context& io, const std::string& flag, const shell::HostPort& where,
                      const Udp::endpoint* own) {
  return resolve_all(io, flag, where, own).front();
}

std::vector<Udp::endpoint> resolve_all(asio::io_context& io, const std::string& flag, const shell::HostPort& where,
                                       const Udp::endpoint* own) {
  Udp::resolver resolver(io);
  error_code error;
  const auto found = resolver.resolve(where.host, std::to_string(where.port), error);
  const std::string failure =
      flag + ": cannot resolve '" + where.host + "': " + (error ? error.message() : "no address");
  if (error == asio::error::host_not_found_try_again) throw NotResolvedYet(failure);
  if (error || found.empty()) throw UserError(failure);
  const Udp wanted = own != nullptr ? own->protocol() : Udp::v4();
  std::vector<Udp::endpoint> all;
  for (const auto& entry : found) all.push_back(as_it_is(entry.endpoint()));
  const auto others = std::stable_partition(all.begin(), all.end(),
                                            [wanted](const Udp::endpoint& e) { return e.protocol() == wanted; });
  const bool is_wanted = others != all.begin();
  if (own != nullptr ? is_of_one_family(*own) : is_wanted) all.erase(others, all.end());
  if (!all.empty()) return all;
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

UdpSocket::UdpSocket(asio::io_context& io, const Udp::endpoint& address)
    : socket_(io), v4_(address.address().is_v4()), inbox_(new std::byte[kBatch * kLongest]) {
  error_code error;
  socket_.open(address.protocol(), error);
  if (!error && !v4_) socket_.set_option(asio::ip::v6_only(is_of_one_family(address)), error);
  if (!error) socket_.bind(address, error);
  if (!error) socket_.non_blocking(true, error);
  if (error) throw std::system_error(error, "cannot listen on " + to_string(to_endpoint(address)));
  error_code ignored;  // the system's default will do
  socket_.set_option(asio::socket_base::receive_buffer_size(kReceiveBufferBytes), ignored);
  // Otherwise a socket that is not connected hears nothing of what became of its datagrams.
  const int on = 1;
  setsockopt(socket_.native_handle(), IPPROTO_IP, IP_RECVERR, &on, sizeof(on));
  if (!v4_) setsockopt(socket_.native_handle(), IPPROTO_IPV6, IPV6_RECVERR, &on, sizeof(on));
}

void UdpSocket::start(Receiver each, Refusal refused, std::function<void()> afterwards) {
  each_ = std::move(each);
  refused_ = std::move(refused);
  afterwards_ = std::move(afterwards);
  wait();
}

void UdpSocket::close() {
  error_code ignored;
  socket_.close(ignored);
}

void UdpSocket::wait() {
  socket_.async_wait(Udp::socket::wait_read, KeptIn(memory_, [this](const error_code& error) {
                       if (error == asio::error::operation_aborted || !socket_.is_open()) return;
                       read();
                       afterwards_();
                       if (socket_.is_open()) wait();
                     }));
}

void UdpSocket::read() {
  std::array<Udp::endpoint, kBatch> from;
  std::array<iovec, kBatch> parts{};
  std::array<mmsghdr, kBatch> messages{};
  for (std::size_t i = 0; i < kBatch; ++i) {
    parts[i] = {&inbox_[i * kLongest], kLongest};
    messages[i].msg_hdr.msg_name = from[i].data();
    messages[i].msg_hdr.msg_iov = &parts[i];
    messages[i].msg_hdr.msg_iovlen = 1;
  }
  for (int round = 0; round < kRoundsPerWakeUp && socket_.is_open(); ++round) {
    for (std::size_t i = 0; i < kBatch; ++i)
      messages[i].msg_hdr.msg_namelen = static_cast<socklen_t>(from[i].capacity());
    const int got = recvmmsg(socket_.native_handle(), messages.data(), kBatch, MSG_DONTWAIT, nullptr);
    if (got < 0) {
      // Woken by news alone, of which a datagram sent since has been told: as long as they are there, no wait would
      // last.
      if (errno == EAGAIN || errno == EWOULDBLOCK) return round == 0 ? read_refusals() : void();
      // News about an earlier datagram, mostly, in which case there is more to be read of it.
      if (errno != ECONNREFUSED) ++stats_.receive_errors;
      last_error_ = error_code(errno, boost::system::system_category()).message();
      read_refusals();
      continue;
    }
    const auto count = static_cast<std::size_t>(got);
    for (std::size_t i = 0; i < count && socket_.is_open(); ++i) {
      from[i].resize(messages[i].msg_hdr.msg_namelen);
      each_(to_endpoint(from[i]), {&inbox_[i * kLongest], messages[i].msg_len});
    }
    if (count < kBatch) return;  // what has come since wakes us again
  }
}

void UdpSocket::remember(const Endpoint& to, std::span<const std::byte> datagram) {
  Sent& s = sent_[next_sent_++ % sent_.size()];
  s.to = to;
  s.size = std::min(datagram.size(), kQuoted);
  std::copy_n(datagram.begin(), s.size, s.begin.begin());
}

// Anybody can say that nobody listens at a port. To quote what was sent there one must have seen it.
void UdpSocket::take_refusal(const Endpoint& at, std::span<const std::byte> quoted) {
  ++stats_.refused;
  const bool ours = std::any_of(sent_.begin(), sent_.end(), [&](const Sent& s) {
    return s.size > 0 && s.to == at && quoted.size() >= s.size &&
           std::equal(s.begin.begin(), s.begin.begin() + static_cast<std::ptrdiff_t>(s.size), quoted.begin());
  });
  if (ours && refused_) refused_(at);
}

void UdpSocket::read_refusals() {
  for (int i = 0; i < kNewsPerWakeUp; ++i) {
    Udp::endpoint to;
    std::array<std::byte, kQuoted> quoted{};
    iovec part{quoted.data(), quoted.size()};
    alignas(cmsghdr) std::array<std::byte, 512> about{};
    msghdr message{};
    message.msg_name = to.data();
    message.msg_namelen = static_cast<socklen_t>(to.capacity());
    message.msg_control = about.data();
    message.msg_controllen = about.size();
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    const ssize_t size = recvmsg(socket_.native_handle(), &message, MSG_ERRQUEUE);
    if (size < 0) return;
    if (message.msg_namelen == 0) continue;
    to.resize(message.msg_namelen);
    for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
      const bool told = (c->cmsg_level == IPPROTO_IP && c->cmsg_type == IP_RECVERR) ||
                        (c->cmsg_level == IPPROTO_IPV6 && c->cmsg_type == IPV6_RECVERR);
      if (!told) continue;
      sock_extended_err e{};
      std::memcpy(&e, CMSG_DATA(c), sizeof(e));
      if (e.ee_errno != ECONNREFUSED) continue;
      take_refusal(to_endpoint(to), std::span(quoted).first(static_cast<std::size_t>(size)));
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

void UdpSocket::post(const Endpoint& to, std::span<const std::byte> datagram) {
  const bool reachable = !v4_ || to.is_v4();
  posted_.push_back({to, reachable ? to_asio(to, v4_) : Udp::endpoint(), posted_bytes_.size(), datagram.size()});
  posted_bytes_.insert(posted_bytes_.end(), datagram.begin(), datagram.end());
}

// So many of them from that one on, as far as the system takes them in one call.
std::size_t UdpSocket::send_posted(std::size_t from) {
  const auto send_first = [this](mmsghdr* messages, std::size_t count) {
    const int sent = sendmmsg(socket_.native_handle(), messages, static_cast<unsigned>(count), MSG_DONTWAIT);
    return static_cast<std::size_t>(std::max(sent, 0));
  };
  std::array<iovec, kBatch> parts{};
  std::array<mmsghdr, kBatch> messages{};
  const std::size_t count = std::min(kBatch, posted_.size() - from);
  for (std::size_t i = 0; i < count; ++i) {
    Posted& p = posted_[from + i];
    if (v4_ && !p.to.is_v4()) return i == 0 ? 0 : send_first(messages.data(), i);
    parts[i] = {&posted_bytes_[p.at], p.size};
    messages[i].msg_hdr.msg_name = p.where.data();
    messages[i].msg_hdr.msg_namelen = static_cast<socklen_t>(p.where.size());
    messages[i].msg_hdr.msg_iov = &parts[i];
    messages[i].msg_hdr.msg_iovlen = 1;
  }
  return send_first(messages.data(), count);
}

void UdpSocket::flush(const Outcome& each) {
  for (std::size_t next = 0; next < posted_.size();) {
    const std::size_t sent = send_posted(next);
    for (std::size_t i = 0; i < sent; ++i, ++next) {
      const Posted& p = posted_[next];
      const std::span<const std::byte> datagram(&posted_bytes_[p.at], p.size);
      remember(p.to, datagram);
      ++stats_.sent;
      each(p.to, datagram, true);
    }
    if (sent > 0 || next == posted_.size()) continue;
    // One that does not go: by itself, which finds out why.
    const Posted& p = posted_[next++];
    const std::span<const std::byte> datagram(&posted_bytes_[p.at], p.size);
    each(p.to, datagram, send(p.to, datagram));
  }
  posted_.clear();
  posted_bytes_.clear();
}

bool UdpSocket::send(const Endpoint& to, std::span<const std::byte> datagram) {
  error_code error;
  if (v4_ && !to.is_v4()) {
    error = asio::error::address_family_not_supported;
  } else {
    const Udp::endpoint where = to_asio(to, v4_);
    const auto bytes = asio::buffer(datagram.data(), datagram.size());
    socket_.send_to(bytes, where, 0, error);
    if (error && error != asio::error::would_block) {
      // News about an earlier datagram, perhaps, which kept this one from being sent.
      read_refusals();
      socket_.send_to(bytes, where, 0, error);
    }
  }
  if (!error) {
    remember(to, datagram);
    ++stats_.sent;
    return true;
  }
  const bool full = error == asio::error::would_block || error == asio::error::no_buffer_space;
  ++(full ? stats_.buffer_full : stats_.send_errors);
  last_error_ = error.message();
  return false;
}

}  // namespace padr::shell
