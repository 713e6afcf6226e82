#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/link/netem_spec.h"
#include "common/link/shim.h"
#include "common/model/rng.h"
#include "common/participant/session.h"
#include "common/wire/seal.h"

namespace padr::test {

/// 10.0.0.n:7000.
inline Endpoint place(int n) {
  return ipv4({10, 0, 0, static_cast<std::uint8_t>(n)}, 7000);
}

/// The config of a peer that fits every other one of these.
inline node::SessionConfig alike(std::uint64_t seed) {
  node::SessionConfig c;
  c.scene_hash = 0x5CE4E;
  c.fingerprint = 0xF14;
  c.scenario = "arena seed 1";
  c.seed = seed;
  return c;
}

/// Sessions at places 1, 2, ... on one virtual clock, every directed link through a shim. Each peer's own clock is off
/// by hours from the others'.
class VirtualNet {
 public:
  explicit VirtualNet(std::uint64_t seed, const std::string& netem = "")
      : seed_(seed), spec_(link::parse_netem(netem)) {}

  /// For links between two places, both made by `set_link` before anything is sent on them.
  void set_link(int from, int to, const std::string& netem) {
    own_[{place(from), place(to)}] = link::parse_netem(netem);
  }

  /// The session at place `n` begins now.
  node::Session& add(int n, const node::SessionConfig& config) {
    auto& s = sessions_[place(n)];
    s = std::make_unique<node::Session>(config, local(n));
    return *s;
  }
  void remove(int n) { sessions_.erase(place(n)); }
  node::Session& at(int n) { return *sessions_.at(place(n)); }

  Micros now() const { return now_; }
  /// What the clock of the peer at place n shows.
  Micros local(int n) const { return now_ + n * 3'600'000'000LL; }

  void send(int from, int to, std::span<const std::byte> datagram) {
    shim(place(from), place(to)).accept(now_, datagram);
  }
  /// As if from anybody, at once.
  std::optional<PeerId> inject(const Endpoint& from, int to, std::span<const std::byte> datagram) {
    return hand(at(to), from, datagram, local(to));
  }

  /// Runs for `span` us, or until `until` says so; true if it did.
  template <typename Until>
  bool run(Micros span, const Until& until) {
    for (const Micros end = now_ + span; now_ < end; now_ += kStep) {
      for (auto& [where, session] : sessions_) {
        const int n = where.address[15];
        if (local(n) >= session->next_due()) session->advance(local(n));
        for (const auto& d : session->take_outgoing()) {
          ++sent_[{where, d.to}];
          largest_[{where, d.to}] = std::max(largest_[{where, d.to}], d.bytes.size());
          shim(where, d.to).accept(now_, d.bytes);
        }
        for (const auto& note : session->take_notes()) notes_[n].push_back(note.text);
      }
      for (auto& [ends, s] : shims_) {
        while (const auto datagram = s->release(now_)) {
          const auto to = sessions_.find(ends.second);
          if (to == sessions_.end()) continue;
          hand(*to->second, ends.first, *datagram, local(to->first.address[15]));
        }
      }
      if (until()) return true;
    }
    return false;
  }
  void run(Micros span) {
    run(span, [] { return false; });
  }

  bool all(node::SessionPhase phase) const {
    for (const auto& [where, s] : sessions_)
      if (s->phase() != phase) return false;
    return true;
  }
  std::uint64_t sent(const Endpoint& from, const Endpoint& to) { return sent_[{from, to}]; }
  std::size_t largest(const Endpoint& from, const Endpoint& to) { return largest_[{from, to}]; }
  const std::vector<std::string>& notes(int n) { return notes_[n]; }
  /// Whether a note of the peer at place n contains `words`.
  bool noted(int n, const std::string& words) {
    for (const auto& text : notes_[n])
      if (text.find(words) != std::string::npos) return true;
    return false;
  }
  std::string story() const {
    std::string s = "seed " + std::to_string(seed_) + " after " + std::to_string(now_) + " us";
    for (const auto& [n, notes] : notes_)
      for (const auto& text : notes) s += "\n  " + std::to_string(n) + ": " + text;
    for (const auto& [where, session] : sessions_)
      s += "\n  " + to_string(where) + " phase " + std::to_string(static_cast<int>(session->phase())) + " " +
           session->failure();
    return s;
  }

  static constexpr Micros kStep = 1'000;

 private:
  /// Of a state datagram for a replica, the sender.
  static std::optional<PeerId> hand(node::Session& session, const Endpoint& from, std::span<const std::byte> datagram,
                                    Micros local) {
    wire::SealError refused{};
    std::uint8_t version = 0;
    const auto opened = wire::open(datagram, refused, &version);
    if (!opened) {
      session.on_refused(from, datagram.size(), refused, version, local);
      return std::nullopt;
    }
    return session.receive(from, *opened, local) ? std::optional(opened->header.sender) : std::nullopt;
  }

  using Ends = std::pair<Endpoint, Endpoint>;
  link::Shim& shim(const Endpoint& from, const Endpoint& to) {
    auto& s = shims_[{from, to}];
    if (!s) {
      const auto own = own_.find({from, to});
      s = std::make_unique<link::Shim>(own == own_.end() ? spec_ : own->second,
                                       derive_seed(seed_, from.address[15], to.address[15]));
    }
    return *s;
  }

  std::uint64_t seed_;
  link::NetemSpec spec_;
  Micros now_ = 0;
  std::map<Endpoint, std::unique_ptr<node::Session>> sessions_;
  std::map<Ends, link::NetemSpec> own_;
  std::map<Ends, std::unique_ptr<link::Shim>> shims_;
  std::map<Ends, std::uint64_t> sent_;
  std::map<Ends, std::size_t> largest_;
  std::map<int, std::vector<std::string>> notes_;
};

}  // namespace padr::test
