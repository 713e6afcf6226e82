#include "peer/addresses.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "common/model/own_address.h"
#include "common/model/user_error.h"

namespace padr::peer {
namespace {

bool is_zero(std::uint8_t b) {
  return b == 0;
}

std::optional<Endpoint> endpoint_of(const sockaddr& address, std::uint16_t port) {
  const bool v4 = address.sa_family == AF_INET;
  if (!v4 && address.sa_family != AF_INET6) return std::nullopt;
  shell::Udp::endpoint e(v4 ? shell::Udp::v4() : shell::Udp::v6(), 0);
  std::memcpy(e.data(), &address, e.size());
  e.port(port);
  return shell::to_endpoint(e);
}

}  // namespace

std::vector<Contact> join_addresses(boost::asio::io_context& io, const Options& o) {
  std::vector<Contact> all;
  std::optional<shell::Udp::endpoint> own;
  if (o.listen && !o.join.empty()) own = shell::resolve(io, "--listen", *o.listen);
  for (const shell::HostPort& member : o.join) {
    const auto found = shell::resolve_all(io, "--join", member, own ? &*own : nullptr);
    for (const shell::Udp::endpoint& at : found) all.push_back({member.text, shell::to_endpoint(at)});
    if (!own) own = found.front();
  }
  return all;
}

shell::Udp::endpoint listen_address(boost::asio::io_context& io, const Options& o, const std::vector<Contact>& join) {
  const bool v6 = !join.empty() && !join.front().at.is_v4();
  const auto outside =
      std::find_if(join.begin(), join.end(), [](const auto& member) { return !member.at.is_loopback(); });
  const std::string whom = outside == join.end() ? "" : outside->text;
  if (!o.listen) {
    if (!whom.empty())
      throw UserError("--join: " + whom + " is not on this machine, and without --listen a peer stays on the " +
                      "loopback address; give --listen " + (v6 ? "'[::]:0'" : "0.0.0.0:0") +
                      (o.key     ? ""
                       : o.crowd ? " and --insecure"
                                 : " and --key-file FILE, or --insecure"));
    if (v6) return {boost::asio::ip::address_v6::loopback(), 0};
    return {boost::asio::ip::address_v4::loopback(), 0};
  }
  shell::Udp::endpoint listen = shell::resolve(io, "--listen", *o.listen);
  if (!listen.address().is_loopback() && !o.insecure && !o.key)
    throw UserError("--listen: " + o.listen->text +
                    " can be reached by other machines, and nothing proves who sends a datagram; give " +
                    (o.crowd ? "" : "--key-file FILE, ") +
                    "a loopback address, or --insecure if you trust the network");
  if (!whom.empty() && listen.address().is_loopback())
    throw UserError("--listen: " + o.listen->text + " is a loopback address, which cannot reach --join " + whom);
  return listen;
}

std::vector<Endpoint> own_addresses(const Endpoint& local) {
  const bool any_v4 = local.is_v4() && std::all_of(local.address.begin() + 12, local.address.end(), is_zero);
  const bool any_v6 = local.address == Endpoint{}.address;
  if (!any_v4 && !any_v6) return is_of_one_host(local) ? std::vector{local.place()} : std::vector<Endpoint>{};
  ifaddrs* found = nullptr;
  if (getifaddrs(&found) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> all(found, &freeifaddrs);
  std::vector<Endpoint> own;
  for (const ifaddrs* i = all.get(); i != nullptr; i = i->ifa_next) {
    if (i->ifa_addr == nullptr || (i->ifa_flags & IFF_UP) == 0) continue;
    const auto e = endpoint_of(*i->ifa_addr, local.port);
    if (e && is_of_one_host(*e) && (any_v6 || e->is_v4())) own.push_back(*e);
  }
  // Two peers behind one NAT have IPv4 in common; by IPv6 most reach each other anyway.
  std::stable_partition(own.begin(), own.end(), [](const Endpoint& e) { return e.is_v4(); });
  if (own.size() > kMostOwnAddresses) own.resize(kMostOwnAddresses);
  return own;
}

}  // namespace padr::peer
