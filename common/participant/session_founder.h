#pragma once

#include <string>
#include <vector>

#include "common/membership/session_state.h"
#include "common/sync/transfer.h"

namespace padr::node {

/// The founder's part of a session: lets newcomers in or refuses them, and starts when all who are wanted are ready.
class Founder {
 public:
  Founder(SessionState& session, Micros local);

  void on_join(const Endpoint& from, const wire::Join& join, Micros local);
  void on_ping(const Endpoint& from, const wire::Ping& ping, Micros local);
  void on_ready(const Endpoint& from, const wire::Ready& ready, Micros local);
  void on_bye(const Endpoint& from, const wire::Bye& bye);
  void advance(Micros local);
  void leave(const std::string& reason);

 private:
  /// A newcomer that was given a number. Their count is bounded by that of the peers wanted.
  struct Guest {
    Endpoint at;
    std::uint64_t nonce = 0;
    PeerId peer = kNoPeer;
    Micros heard = 0;
    bool proven = false;  ///< has shown that it hears us at its address
    bool ready = false;   ///< has agreed its clock
    bool started = false;
    Micros round_trip = 0;
    Micros start_sent = 0;
  };
  Guest* guest_at(const Endpoint& where);
  Guest* admit(const Endpoint& from, const wire::Join& join, Micros local);
  void begin_now(Micros session, Micros local);
  /// Why not; empty if the newcomer fits.
  std::string objection(const wire::Join& join) const;
  void refuse(const Endpoint& to, const wire::Join& join, const std::string& reason, Micros local);
  void dismiss_silent(Micros local);
  bool all_ready() const;
  void start(Micros local);
  void repeat_start(Micros local);
  void send_start(const Endpoint& to);
  void count_present();

  SessionState& session_;
  std::vector<Guest> guests_;  ///< by number
  Micros tick0_ = 0;
};

}  // namespace padr::node
