#pragma once

#include <memory>
#include <string>

#include "peer/controls.h"
#include "peer/health.h"
#include "peer/loop.h"
#include "peer/player.h"
#include "peer/recordings.h"
#include "peer/session_key.h"
#include "peer/status.h"
#include "peer/telemetry.h"

namespace padr::peer {

/// A session: comes together with the others, plays, leaves.
class EventLoop final : public Loop {
 public:
  /// As of Loop.
  EventLoop(const Options& options, Log& log, const shell::Clock& clock);

 private:
  void open_all_files();
  void start() override;
  void receive(const Endpoint& from, std::span<const std::byte> datagram, Micros now) override;
  void unreachable(const Endpoint& at, Micros now) override { player_->unreachable(at, now); }
  void advance(Micros now) override;
  Micros next_due() const override;
  void stop(const std::string& signal, Micros now) override;
  void end(int code, const std::string& reason) override;
  void finish() override;
  std::string summary_text() const override;
  void send_out(Micros now);
  void end_if_over(Micros now);
  /// After a signal: ends, or leaves if it has come in meanwhile.
  void give_up_coming(Micros now);
  void say_status(Micros now);
  Telemetry::Situation situation() const { return {*player_, *egress_, cuts_, local_}; }

  std::unique_ptr<Recordings> recordings_;
  std::unique_ptr<Keylog> keylog_;        ///< null if nobody asked for it
  std::unique_ptr<Health> health_;        ///< null if nobody asked for it
  std::unique_ptr<Telemetry> telemetry_;  ///< null: there is no monitor
  std::unique_ptr<Player> player_;
  std::unique_ptr<Controls> controls_;  ///< null: nobody orders anything
  std::string signal_;                  ///< that has told it to leave
  std::optional<Micros> comes_until_;   ///< after a signal: it is being admitted
  Status status_;
};

}  // namespace padr::peer
