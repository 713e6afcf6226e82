#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/crowd/crowd_peer.h"
#include "common/scenarios/input.h"
#include "peer/crowd_summary.h"
#include "peer/loop.h"

namespace padr::peer {

/// A peer of a crowd: comes in, walks about, leaves.
class CrowdLoop final : public Loop {
 public:
  /// As of Loop.
  CrowdLoop(const Options& options, Log& log, const shell::Clock& clock);

 private:
  void make_peer();
  void receive(const Endpoint& from, std::span<const std::byte> datagram, Micros now) override {
    peer_->receive(from, datagram, now);
  }
  void unreachable(const Endpoint& at, Micros now) override;
  void advance(Micros now) override;
  Micros next_due() const override;
  void stop(const std::string& signal, Micros now) override;
  std::string summary_text() const override;
  void turn(Micros now);
  void tell();
  void note_playing(Micros now);
  void leave(const std::string& why, Micros now);
  void end_if_over(Micros now);
  void say_status(Micros now);

  std::unique_ptr<crowd::CrowdPeer> peer_;
  std::unique_ptr<scenarios::InputSource> input_;
  CrowdRecord record_;
  std::uint64_t told_bytes_ = 0;
  Micros told_at_ = 0;
  std::optional<Micros> left_at_;
  bool nobody_listens_ = false;  ///< where it asked for the crowd
};

}  // namespace padr::peer
