#include "peer/port_mapping.h"

#include <arpa/inet.h>
#include <miniupnpc/miniupnpc.h>
#include <miniupnpc/upnpcommands.h>
#include <natpmp.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <utility>

namespace padr::peer {
namespace {

using Clock = std::chrono::steady_clock;

/// So long the router keeps the mapping if this process vanishes, s. RFC 6886 recommends twice as much.
constexpr std::uint32_t kLifetime = 3600;
constexpr auto kRenewEvery = std::chrono::seconds(kLifetime / 3);
/// A router that speaks NAT-PMP answers within milliseconds.
constexpr auto kNatPmpPatience = std::chrono::milliseconds(1000);
/// UPnP routers may take so long to answer a search, ms.
constexpr int kUpnpSearch = 2000;
constexpr const char* kUdp = "UDP";

Endpoint endpoint_of(in_addr address, std::uint16_t port) {
  const std::uint32_t a = ntohl(address.s_addr);
  return ipv4({static_cast<std::uint8_t>(a >> 24U), static_cast<std::uint8_t>(a >> 16U),
               static_cast<std::uint8_t>(a >> 8U), static_cast<std::uint8_t>(a)},
              port);
}

/// A conversation with the default gateway by NAT-PMP.
class NatPmp {
 public:
  NatPmp() : open_(initnatpmp(&state_, 0, 0) == 0) {}
  NatPmp(const NatPmp&) = delete;
  NatPmp& operator=(const NatPmp&) = delete;
  ~NatPmp() {
    if (open_) closenatpmp(&state_);
  }

  std::optional<in_addr> address() {
    const auto answer = ask([this] { return sendpublicaddressrequest(&state_); }, NATPMP_RESPTYPE_PUBLICADDRESS);
    if (!answer) return std::nullopt;
    return answer->pnu.publicaddress.addr;
  }
  /// The port outside; `lifetime` 0 takes the mapping back.
  std::optional<std::uint16_t> map(std::uint16_t port, std::uint16_t outside, std::uint32_t lifetime) {
    const auto answer =
        ask([&] { return sendnewportmappingrequest(&state_, NATPMP_PROTOCOL_UDP, port, outside, lifetime); },
            NATPMP_RESPTYPE_UDPPORTMAPPING);
    if (!answer || answer->pnu.newportmapping.privateport != port) return std::nullopt;
    return answer->pnu.newportmapping.mappedpublicport;
  }

 private:
  /// libnatpmp repeats a question that is not answered at once, so a slow router's second answer to the one before may
  /// come first. The question is then asked again.
  template <typename Question>
  std::optional<natpmpresp_t> ask(const Question& question, std::uint16_t type) {
    const auto end = Clock::now() + kNatPmpPatience;
    while (open_ && question() >= 0) {
      const auto answer = wait(end);
      if (!answer || answer->type == type) return answer;
    }
    return std::nullopt;
  }

  std::optional<natpmpresp_t> wait(Clock::time_point end) {
    for (;;) {
      natpmpresp_t answer{};
      const int result = readnatpmpresponseorretry(&state_, &answer);
      if (result == 0) return answer;
      if (result != NATPMP_TRYAGAIN || Clock::now() >= end) return std::nullopt;
      timeval next{};
      getnatpmprequesttimeout(&state_, &next);
      const long ms = std::clamp(next.tv_sec * 1000 + next.tv_usec / 1000, 1L, 100L);
      pollfd readable{state_.s, POLLIN, 0};
      poll(&readable, 1, static_cast<int>(ms));
    }
  }

  natpmp_t state_{};
  bool open_;
};

/// The router that a search by UPnP finds.
class Upnp {
 public:
  Upnp() {
    int error = 0;
    const std::unique_ptr<UPNPDev, decltype(&freeUPNPDevlist)> found(
        upnpDiscover(kUpnpSearch, nullptr, nullptr, UPNP_LOCAL_PORT_ANY, 0, 2, &error), &freeUPNPDevlist);
    if (!found) return;
#if MINIUPNPC_API_VERSION >= 18
    const int kind =
        UPNP_GetValidIGD(found.get(), &urls_, &data_, own_.data(), static_cast<int>(own_.size()), nullptr, 0);
#else
    const int kind = UPNP_GetValidIGD(found.get(), &urls_, &data_, own_.data(), static_cast<int>(own_.size()));
#endif
    described_ = kind != 0;
    connected_ = kind == 1;
  }
  Upnp(const Upnp&) = delete;
  Upnp& operator=(const Upnp&) = delete;
  ~Upnp() {
    if (described_) FreeUPNPUrls(&urls_);
  }

  std::optional<in_addr> address() const {
    std::array<char, 64> text{};
    in_addr address{};
    if (!connected_ || UPNP_GetExternalIPAddress(urls_.controlURL, service(), text.data()) != UPNPCOMMAND_SUCCESS ||
        inet_pton(AF_INET, text.data(), &address) != 1)
      return std::nullopt;
    return address;
  }
  bool map(std::uint16_t port) const {
    const std::string number = std::to_string(port);
    const std::string seconds = std::to_string(kLifetime);
    return connected_ && UPNP_AddPortMapping(urls_.controlURL, service(), number.c_str(), number.c_str(), own_.data(),
                                             "padr-peer", kUdp, nullptr, seconds.c_str()) == UPNPCOMMAND_SUCCESS;
  }
  void take_back(std::uint16_t port) const {
    if (connected_) UPNP_DeletePortMapping(urls_.controlURL, service(), std::to_string(port).c_str(), kUdp, nullptr);
  }

 private:
  const char* service() const {
    return data_.first.servicetype;
  }

  UPNPUrls urls_{};
  IGDdatas data_{};
  std::array<char, 64> own_{};  ///< this machine's address, as the router sees it
  bool described_ = false;
  bool connected_ = false;
};

}  // namespace

PortMapping::PortMapping(std::uint16_t port, std::function<void()> lost) : port_(port), lost_(std::move(lost)) {
  if (ask_nat_pmp() || ask_upnp()) thread_ = std::thread([this] { keep(); });
}

PortMapping::~PortMapping() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  ends_.notify_all();
  thread_.join();
}

bool PortMapping::ask_nat_pmp() {
  NatPmp router;
  const auto address = router.address();
  if (!address) return false;
  const auto port = router.map(port_, port_, kLifetime);
  if (!port) return false;
  outside_ = endpoint_of(*address, *port);
  protocol_ = "NAT-PMP";
  return true;
}

bool PortMapping::ask_upnp() {
  const Upnp router;
  const auto address = router.address();
  if (!address || !router.map(port_)) return false;
  outside_ = endpoint_of(*address, port_);
  protocol_ = "UPnP";
  return true;
}

bool PortMapping::renew() {
  if (protocol_ == "UPnP") return Upnp().map(port_);
  return NatPmp().map(port_, outside_->port, kLifetime) == outside_->port;
}

void PortMapping::take_back() {
  if (protocol_ == "UPnP")
    Upnp().take_back(port_);
  else
    NatPmp().map(port_, 0, 0);
}

void PortMapping::keep() {
  std::unique_lock lock(mutex_);
  bool told = false;
  while (!ends_.wait_for(lock, kRenewEvery, [this] { return ending_; })) {
    lock.unlock();
    if (!renew() && !std::exchange(told, true)) lost_();
    lock.lock();
  }
  take_back();
}

}  // namespace padr::peer
