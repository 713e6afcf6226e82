#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "tools/monitor/drivers.h"
#include "tools/monitor/observed_sessions.h"
#include "tools/monitor/order_desk.h"
#include "tools/monitor/page_server.h"

namespace padr::monitor {

/// Peers that play now: what they tell goes to the pages, what pages want goes to them.
class Live : public PageServer {
 public:
  /// `issuer`: as OrderDesk's. `note`: takes lines for the log.
  Live(const Options& options, std::string source, std::uint64_t issuer, OrderDesk::Sender send,
       std::function<void(const std::string&)> note);

  /// A datagram from a peer.
  void receive(const Endpoint& from, std::span<const std::byte> datagram, Micros now);
  void advance(Micros now) override;

 private:
  void introduce(ViewerId viewer) override;
  void act(ViewerId viewer, const Asked& asked) override;
  void gone(ViewerId viewer) override;
  std::string session_json() override;
  std::string metrics() override;
  std::string path_csv(PeerId slot) override { return paths_.csv(slot); }

  void drive(ViewerId viewer, const Asked& asked, PeerId slot, const Drive& drive);
  void release(const std::vector<PeerId>& slots);
  /// Whom a command is for. Empty, with the reason, if it cannot be followed.
  std::vector<const PeerRecord*> meant(const Command& c, std::string& why) const;
  void watch_session();
  void pass_events();
  void follow_frames();
  std::string peers_for(ViewerId viewer);
  void tell_peers();
  /// Changes when the table should be told at once.
  std::uint64_t fingerprint() const;

  ObservedSessions sessions_;
  OrderDesk orders_;
  std::function<void(const std::string&)> note_;
  Drivers drivers_;
  DrivenPaths paths_;
  const ObservedSession* known_ = nullptr;
  std::uint64_t passed_ = 0;  ///< events of the session that is shown
  Tick sampled_ = -1;
  Micros next_sample_ = 0;
  Micros next_peers_ = 0;
  Micros next_sweep_ = 0;
  std::uint64_t fingerprint_ = 0;
  std::uint64_t serial_ = 0;
};

}  // namespace padr::monitor
