#pragma once

#include <deque>

#include "tools/lab/alternatives/playout.h"
#include "tools/lab/alternatives/quantised.h"
#include "tools/lab/alternatives/replica.h"

namespace padr::lab::alternatives {

/// Snapshots (Quake 3; Valve, "Source Multiplayer Networking"; Fiedler, "Snapshot Interpolation" and "Snapshot
/// Compression"): at a fixed rate a peer sends to each other the places of its avatar and of all bodies that it owns,
/// as the difference to the newest snapshot that is known to have arrived there, or to the scenario. A snapshot has no
/// velocities. Nothing is repeated: the next one says all. When nothing has changed, one goes out twice a second only.
///
/// The receiver shows what others own at a playout delay, between the two snapshots around that time (see Playout).
/// What it owns itself, it simulates now.
class Snapshot final : public Replica {
 public:
  Snapshot(const Scene& scene, const AlternativeConfig& config);
  Tick delay(PeerId of) const override { return links_[of].playout.delay(); }

 protected:
  bool take(PeerId from, BitReader& r) override;
  void place_others() override;
  void send() override;

 private:
  struct Link {
    std::deque<Content> sent;      ///< oldest first, from the acknowledged one on
    std::deque<Content> received;  ///< newest last; what the other end may still build on
    Playout playout;
    Tick sent_at = -1000;
    Tick newest = -1;         ///< received
    bool owes_ack = false;    ///< something new has come since the last datagram
    std::uint8_t number = 0;  ///< of the last datagram sent
  };

  Content present() const;
  void send_to(PeerId to, const Content& here);
  bool idle(const Link& link, const Content& here) const;
  void forget(Link& link, Tick acknowledged);
  std::uint64_t write_content(BitWriter& w, const Content& base, Content& here) const;
  void write_piece(BitWriter& w, const Piece& base, const Piece& p) const;
  bool read_content(BitReader& r, Content& out) const;
  bool read_piece(BitReader& r, Piece& p) const;
  void place_avatar(PeerId p);
  void place_body(EntityId b);

  Quantiser quantiser_;
  std::vector<Link> links_;         ///< by peer
  Content initial_;                 ///< known to all
  std::vector<Claim> shown_claim_;  ///< by body: whose word it was that was shown last
  std::vector<BodyState> shown_;    ///< by entity
};

}  // namespace padr::lab::alternatives
