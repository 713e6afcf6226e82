#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "common/model/endpoint.h"

namespace padr::peer {

/// A UDP port of this machine that the router of its network forwards to it. It is asked by NAT-PMP (RFC 6886), then by
/// UPnP IGD. The mapping is renewed until this is destroyed, which takes it back.
class PortMapping {
 public:
  /// Asks for the same number outside; the router may choose another one. Takes 4 s at most. Does not throw.
  /// `lost`: called once, by another thread, if the router no longer renews the mapping.
  PortMapping(std::uint16_t port, std::function<void()> lost);
  PortMapping(const PortMapping&) = delete;
  PortMapping& operator=(const PortMapping&) = delete;
  ~PortMapping();

  /// Where others reach the port; nothing if no router maps it.
  const std::optional<Endpoint>& outside() const { return outside_; }
  /// NAT-PMP or UPnP.
  const std::string& protocol() const { return protocol_; }

 private:
  bool ask_nat_pmp();
  bool ask_upnp();
  bool renew();
  void take_back();
  void keep();

  std::uint16_t port_;
  std::function<void()> lost_;
  std::optional<Endpoint> outside_;
  std::string protocol_;
  std::mutex mutex_;
  std::condition_variable ends_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace padr::peer
