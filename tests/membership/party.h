#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/scenarios/bodies.h"
#include "common/scenarios/scenarios.h"
#include "shell/netem_text.h"
#include "tools/lab/testbed/judge.h"

namespace padr::test {

constexpr Micros seconds(double s) {
  return static_cast<Micros>(s * 1e6);
}

inline lab::VirtualNetworkConfig party_config(int founders, const std::string& netem, std::uint64_t seed,
                                              std::uint32_t bodies = 20) {
  lab::VirtualNetworkConfig c;
  c.scene = scenarios::load(scenarios::with_bodies(scenarios::embedded_text("arena"), "arena", bodies), "arena", seed);
  c.technique = technique_by_name("full");
  c.netem = shell::parse_netem(netem);
  c.seed = seed;
  c.wanted = founders;
  return c;
}

/// Peers on virtual time under the eyes of a judge.
class Party {
 public:
  /// `prepare` gets hold of the network before anybody starts. `at_once`: how many start then; 0: as many as play
  /// waits for.
  explicit Party(lab::VirtualNetworkConfig config, const std::function<void(lab::VirtualNetwork&)>& prepare = {},
                 int at_once = 0)
      : Party(at_once > 0 ? at_once : config.wanted, std::move(config), prepare) {}
  Party(int founders, const std::string& netem, std::uint64_t seed) : Party(party_config(founders, netem, seed)) {}

  lab::VirtualNetwork& net() { return network_; }
  const lab::VirtualNetwork& net() const { return network_; }
  const node::Replica& replica(int person) const { return network_.peer(person).replica(); }
  const lab::Judge& judge() const { return judge_; }
  lab::Judge& judge_too() { return judge_; }

  void run(double s) { network_.run_to(network_.now() + seconds(s)); }
  /// Until `done`, at most `s`; seconds it took, or nothing.
  std::optional<double> run_until(double s, const std::function<bool()>& done) {
    const Micros begin = network_.now();
    while (network_.now() < begin + seconds(s)) {
      network_.run_to(network_.now() + lab::VirtualNetwork::kStep);
      if (done()) return static_cast<double>(network_.now() - begin) / 1e6;
    }
    return std::nullopt;
  }
  /// All who run and do not leave, one another's members, none with anybody else.
  bool united() const {
    std::vector<int> all;
    for (int p = 0; p < network_.persons(); ++p)
      if (network_.runs(p) && !network_.leaving(p)) all.push_back(p);
    for (const int p : all)
      if (!network_.peer(p).playing() || network_.peer(p).returning()) return false;
    return std::all_of(all.begin(), all.end(), [&](int p) {
      int there = 1;
      for (PeerId q = 0; q < replica(p).config().slots; ++q)
        if (q != replica(p).self() && replica(p).seat(q).there()) ++there;
      return there == static_cast<int>(all.size()) && std::all_of(all.begin(), all.end(), [&](int q) {
               return p == q || (replica(p).seat(replica(q).self()).there() &&
                                 replica(p).seat(replica(q).self()).incarnation == replica(q).config().incarnation);
             });
    });
  }
  /// All who run play, and since the same tick.
  bool started() const {
    std::set<Tick> at;
    for (int p = 0; p < network_.persons(); ++p) {
      if (!network_.runs(p)) continue;
      if (!network_.peer(p).playing() || !replica(p).playing()) return false;
      at.insert(replica(p).start().at);
    }
    return at.size() == 1;
  }
  /// In 20 s from now nobody of the first `persons` has begun anew, falls behind, or is no longer with all others.
  void expect_to_stay(int persons) {
    run(20);
    EXPECT_TRUE(united()) << story();
    for (int p = 0; p < persons; ++p) {
      EXPECT_LT(lag(p), 60);
      EXPECT_EQ(network_.peer(p).incarnation(), 0) << story();
    }
    EXPECT_EQ(judge_.violation(), "");
  }
  bool noted(int person, const std::string& words) const {
    const std::vector<std::string> all = network_.notes(person);
    return std::any_of(all.begin(), all.end(), [&](const auto& n) { return n.find(words) != std::string::npos; });
  }
  Tick lag(int person) const { return replica(person).now() - replica(person).agreed().confirmed().tick; }
  std::string story() const {
    std::string s;
    for (int p = 0; p < network_.persons(); ++p)
      for (const std::string& n : network_.notes(p)) s += "person " + std::to_string(p) + ": " + n + "\n";
    return s;
  }

 private:
  Party(int at_once, lab::VirtualNetworkConfig config, const std::function<void(lab::VirtualNetwork&)>& prepare)
      : network_(std::move(config)), judge_(network_) {
    if (prepare) prepare(network_);
    network_.start({});
    for (int p = 1; p < at_once; ++p) network_.start(0);
  }

  lab::VirtualNetwork network_;
  lab::Judge judge_;
};

}  // namespace padr::test
