#pragma once

#include <deque>

#include "tools/lab/alternatives/quantised.h"
#include "tools/lab/alternatives/replica.h"

namespace padr::lab::alternatives {

/// State synchronization (Fiedler, "State Synchronization", with the acknowledgements of his "Networked Physics in
/// Virtual Reality"): everybody simulates everything; a peer sends its input and the states of what it owns, as many
/// as fit into a byte budget, those with the highest accumulated priority first; who receives a state writes it into
/// the simulation, which extrapolates until the next one.
///
/// Priority grows every tick: by 10 for what the own avatar holds, by 1 for what moves; what rests and is acknowledged
/// as it is has none and is not sent. The own avatar and its input (the point it is drawn to) are in every datagram.
/// A state is told as the difference to the last one of the same body that is known to have arrived, if that is not
/// long ago. When there is nothing new, a datagram goes out twice a second only. The budget is 64 kbit/s of payload a
/// link.
///
/// As clocks agree, a state that arrives late is carried forward to now before it is written: an avatar by its control
/// law and the last input, a body by its velocity and the floor's friction. Without that results here are worse.
class StateSync final : public Replica {
 public:
  StateSync(const Scene& scene, const AlternativeConfig& config);

 protected:
  bool take(PeerId from, BitReader& r) override;
  void before_step() override;
  void place_others() override;
  void send() override;

 private:
  /// What one datagram told of a body.
  struct Told {
    EntityId entity = 0;
    std::uint16_t number = 0;  ///< of the datagram
    std::uint16_t sequence = 0;
    bool held = false;
    Quantised state;
  };
  struct Sent {
    std::uint16_t number = 0;
    std::vector<Told> told;
  };
  /// What is known of the link to one peer.
  struct Link {
    std::uint16_t next = 1;
    Tick sent_at = -1000;
    std::deque<Sent> sent;                   ///< not yet acknowledged, the oldest first
    std::vector<Told> acknowledged;          ///< by body: the last that is known to have arrived
    std::vector<std::deque<Told>> received;  ///< by body: what the other end may build on, the newest last
    std::vector<float> priority;             ///< by body
    Vec2 target_told;                        ///< m, of the last datagram
    std::uint16_t newest = 0;                ///< received
    std::uint32_t before_newest = 0;         ///< bit i: newest - 1 - i received
    bool heard = false;
    bool owes_ack = false;
  };

  Told present(EntityId e) const;
  bool is_acknowledged(const Link& link, EntityId body) const;
  std::vector<EntityId> ranked(Link& link) const;
  bool idle(const Link& link, bool nothing) const;
  void write_header(BitWriter& w, const Link& link) const;
  void write(BitWriter& w, const Told& t, const Told& base) const;
  bool read(BitReader& r, Told& t, Link& link) const;
  void send_to(PeerId to);
  void acknowledge(Link& link, std::uint16_t newest, std::uint32_t before);
  bool note(Link& link, std::uint16_t number) const;
  void take_avatar(PeerId from, const BodyState& told, Vec2 target, Tick tick);
  void take_body(const Told& t, PeerId from, Tick tick);
  void carry_avatar(BodyState& s, Vec2 target, Tick ticks) const;
  void carry_body(BodyState& s, EntityId body, Tick ticks) const;

  Quantiser quantiser_;
  int id_bits_;
  std::vector<Link> links_;        ///< by peer
  std::vector<Vec2> targets_;      ///< by peer: last input heard
  std::vector<Tick> avatar_tick_;  ///< by peer: of the last state taken
  struct Newest {
    PeerId from = kNoPeer;
    Tick tick = 0;
  };
  std::vector<Newest> body_tick_;
  std::vector<std::optional<BodyState>> resting_;  ///< by body: as its owner has told
  std::vector<Quantised> initial_;                 ///< by body, as the scenario has it: known to all
};

}  // namespace padr::lab::alternatives
