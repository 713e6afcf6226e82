#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/participant/participant.h"

namespace padr::test {

/// Somebody's datagram on its way.
struct Passing {
  int from = 0;
  int to = 0;
  wire::Bytes bytes;
};

/// A few peers of one sealed session on virtual time, in turns of one tick, on links that take one turn. What they send
/// can be seen, kept back, changed by its sender, and joined by what others make of it.
class SmallNet {
 public:
  SmallNet(int peers, std::uint64_t session, wire::SealMode mode);
  SmallNet(int peers, std::uint64_t session, wire::SealMode mode, const Scene& scene, int slots);
  SmallNet(const SmallNet&) = delete;
  SmallNet& operator=(const SmallNet&) = delete;

  static Endpoint place(int n);
  /// Until all play; false if that takes too long.
  bool come_together();
  /// One tick of everybody.
  void turn();

  int peers() const { return static_cast<int>(people_.size()); }
  const node::Participant& peer(int p) const { return *person(p).peer; }
  /// All that was sent, the newest last; kept up to a bound.
  const std::deque<Passing>& sent() const { return sent_; }
  /// Whether exactly this was sent to that peer by another and has not arrived yet.
  bool awaited(int to, std::span<const std::byte> bytes) const { return person(to).awaited.count(text_of(bytes)) > 0; }
  const wire::Key& session_key() const { return key_; }
  /// The key that a peer signs with.
  wire::SigningKey signing_key(int p) const { return wire::signing_key(wire::derive_key(person(p).seed, "secret")); }
  /// Somebody sends this to a peer; it arrives at once.
  void inject(const Endpoint& from, int to, std::span<const std::byte> bytes);
  /// So many of the next datagrams are lost.
  void lose(int n) { losing_ = n; }

  /// What a sender makes of an unsealed datagram of its own before it is sealed.
  std::function<wire::Bytes(int from, int to, const wire::Bytes& unsealed)> lie;
  /// What becomes of a sender's datagram before it is sealed: as ParticipantConfig::tamper.
  std::function<std::vector<node::Parcel>(int from, node::Parcel)> tamper;
  /// The point that a peer's avatar is drawn to, m; empty: always the same for each.
  std::function<Vec2(int peer)> target;
  /// Something has happened in the session, as a peer sees it.
  std::function<void(int peer, const node::SessionEvent&)> on_event;
  /// A peer has confirmed a tick: peer, tick, hash.
  std::function<void(int, Tick, std::uint64_t)> on_confirmed;

 private:
  struct Person {
    std::unique_ptr<node::Participant> peer;
    wire::Key seed{};
    std::map<PublicKey, wire::Key> keys;  ///< what it sends to whom is sealed with
    std::set<std::string> awaited;        ///< sent to it, and not arrived yet
    std::vector<Passing> coming;
  };
  static std::string text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  const Person& person(int p) const { return people_[static_cast<std::size_t>(p)]; }
  wire::Bytes with_lies(int from, int to, const wire::Bytes& sealed);
  void post(int from, node::Parcel parcel);
  void arrive(int to, const Endpoint& from, std::span<const std::byte> bytes);

  wire::Key key_;
  std::vector<Person> people_;
  std::deque<Passing> sent_;
  int losing_ = 0;
  Micros now_ = 0;
};

}  // namespace padr::test
