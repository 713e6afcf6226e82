#pragma once

#include <algorithm>
#include <array>
#include <deque>
#include <functional>
#include <set>
#include <utility>

#include "tests/channel/two_peers.h"

namespace padr::test {

/// Two peers that know of one another, and send one another something in every turn, through a network that an attacker
/// may hold. On virtual time.
class Talk {
 public:
  struct Network {
    double loss = 0;
    double twice = 0;
    double damage = 0;
    Micros delay = 30'000;
    Micros jitter = 0;
  };
  static constexpr Micros kTurn = 16'667;

  explicit Talk(std::uint64_t seed, wire::SealMode mode = wire::SealMode::kAuth) : rng_(seed) {
    for (const std::size_t n : {0U, 1U}) {
      node::ChannelConfig c = channel_config(2 * seed + n, mode);
      c.on_key = [this, n](const PublicKey&, const PublicKey&, const wire::Key& key) { told[n].push_back(key); };
      peers.emplace_back(std::move(c));
    }
  }

  void run(double seconds) {
    for (const Micros end = now + in_micros(seconds); now < end; now += kTurn) turn();
  }
  Endpoint name_of(std::size_t n) const {
    Endpoint e = place(static_cast<int>(n) + 1);
    e.key = peers[n].key();
    return e;
  }
  std::uint64_t rekeys(std::size_t n) const { return peers[n].stats().rekeys; }
  std::uint64_t dropped(std::size_t n, node::ChannelDrop why) const {
    return peers[n].stats().dropped[static_cast<std::size_t>(why)];
  }
  /// As if it had arrived there. Whether it passed.
  bool deliver(std::size_t to, const Endpoint& from, const wire::Bytes& d) {
    const auto arrival = peers[to].receive(from, d, now);
    if (!arrival) return false;
    wire::Bytes text(arrival->datagram.begin(), arrival->datagram.end());
    ++heard[to];
    if (!passed_[to].insert(std::move(text)).second) ++heard_twice;
    return true;
  }
  /// Of what the other has said since `mark`, the share that came.
  void mark() { said = {}, heard = {}; }
  double share_heard(std::size_t to) const {
    return static_cast<double>(heard[to]) / static_cast<double>(said[1 - to]);
  }

  std::deque<node::SecureChannels> peers;
  Micros now = kMicrosPerSecond;
  Network network;
  std::array<bool, 2> still{};   ///< neither reads nor sends; what comes waits
  std::array<bool, 2> silent{};  ///< only reads, and sends what that makes it send
  std::array<Endpoint, 2> at{place(1), place(2)};
  /// What is sent, and by whom; false: it is lost.
  std::function<bool(std::size_t from, const wire::Bytes&)> lets_through;
  std::array<std::uint64_t, 2> said{};
  std::array<std::uint64_t, 2> heard{};
  std::uint64_t heard_twice = 0;
  std::array<std::vector<wire::Key>, 2> told;  ///< by on_key, in order

 private:
  struct Passing {
    Micros due = 0;
    std::size_t from = 0;
    Endpoint at;
    wire::Bytes bytes;
  };

  void turn() {
    std::stable_sort(wire_.begin(), wire_.end(), [](const auto& a, const auto& b) { return a.due < b.due; });
    for (; !wire_.empty() && wire_.front().due <= now; wire_.pop_front())
      waiting_[1 - wire_.front().from].push_back(wire_.front());
    for (const std::size_t n : {0U, 1U}) {
      if (still[n]) continue;
      for (const Passing& d : std::exchange(waiting_[n], {})) deliver(n, d.at, d.bytes);
      if (!silent[n]) {
        ++said[n];
        peers[n].send(name_of(1 - n), kNoPeer, words(std::to_string(n) + " says " + std::to_string(++words_)), now);
      }
      pass_on(n);
    }
  }
  void pass_on(std::size_t n) {
    for (const auto& p : taken(peers[n])) {
      if (lets_through && !lets_through(n, p.bytes)) continue;
      if (!same_place(p.to, at[1 - n]) || rng_.chance(network.loss)) continue;
      wire::Bytes d = p.bytes;
      if (rng_.chance(network.damage)) d[rng_.below(static_cast<std::uint32_t>(d.size()))] ^= std::byte{4};
      for (int copies = rng_.chance(network.twice) ? 2 : 1; copies > 0; --copies) {
        const auto more = static_cast<Micros>(rng_.below(static_cast<std::uint32_t>(network.jitter + 1)));
        wire_.push_back({now + network.delay + more, n, at[n], d});
      }
    }
  }

  Rng rng_;
  std::uint64_t words_ = 0;
  std::deque<Passing> wire_;
  std::array<std::deque<Passing>, 2> waiting_;
  std::array<std::set<wire::Bytes>, 2> passed_;
};

/// Whether a datagram is a message of this type of the handshake: 1 Hello .. 5 Rekey.
inline bool is_message(const wire::Bytes& d, int type) {
  return wire::is_handshake(d) && std::to_integer<int>(d[3]) == type;
}

}  // namespace padr::test
