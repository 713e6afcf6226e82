#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/scenarios/bodies.h"
#include "common/scenarios/scenarios.h"
#include "tools/lab/chaos/judge.h"

namespace padr::test {

constexpr Micros seconds(double s) {
  return static_cast<Micros>(s * 1e6);
}

inline lab::GatheringConfig party_config(int founders, const std::string& netem, std::uint64_t seed,
                                         std::uint32_t bodies = 20) {
  lab::GatheringConfig c;
  c.scene = scenarios::load(scenarios::with_bodies(scenarios::embedded_text("arena"), "arena", bodies), "arena", seed);
  c.technique = technique_by_name("full");
  c.netem = link::parse_netem(netem);
  c.seed = seed;
  c.wanted = founders;
  return c;
}

/// Peers on virtual time under the eyes of a judge.
class Party {
 public:
  /// `prepare` gets hold of the gathering before anybody starts.
  explicit Party(lab::GatheringConfig config, const std::function<void(lab::Gathering&)>& prepare = {})
      : founders_(config.wanted), gathering_(std::move(config)), judge_(gathering_) {
    if (prepare) prepare(gathering_);
    gathering_.start({});
    for (int p = 1; p < founders_; ++p) gathering_.start(0);
  }
  Party(int founders, const std::string& netem, std::uint64_t seed) : Party(party_config(founders, netem, seed)) {}

  lab::Gathering& net() { return gathering_; }
  const lab::Gathering& net() const { return gathering_; }
  const node::Node& node(int person) const { return gathering_.peer(person).node(); }
  const lab::Judge& judge() const { return judge_; }
  lab::Judge& judge_too() { return judge_; }

  void run(double s) { gathering_.run_to(gathering_.now() + seconds(s)); }
  /// Until `done`, at most `s`; seconds it took, or nothing.
  std::optional<double> run_until(double s, const std::function<bool()>& done) {
    const Micros begin = gathering_.now();
    while (gathering_.now() < begin + seconds(s)) {
      gathering_.run_to(gathering_.now() + lab::Gathering::kStep);
      if (done()) return static_cast<double>(gathering_.now() - begin) / 1e6;
    }
    return std::nullopt;
  }
  /// All who run and do not leave, one another's members, none with anybody else.
  bool united() const {
    std::vector<int> all;
    for (int p = 0; p < gathering_.persons(); ++p)
      if (gathering_.runs(p) && !gathering_.leaving(p)) all.push_back(p);
    for (const int p : all)
      if (!gathering_.peer(p).playing() || gathering_.peer(p).returning()) return false;
    return std::all_of(all.begin(), all.end(), [&](int p) {
      int there = 1;
      for (PeerId q = 0; q < node(p).config().slots; ++q)
        if (q != node(p).self() && node(p).other(q).there()) ++there;
      return there == static_cast<int>(all.size()) && std::all_of(all.begin(), all.end(), [&](int q) {
               return p == q || (node(p).other(node(q).self()).there() &&
                                 node(p).other(node(q).self()).incarnation == node(q).config().incarnation);
             });
    });
  }
  Tick lag(int person) const { return node(person).now() - node(person).agreed().confirmed().tick; }
  std::string story() const {
    std::string s;
    for (int p = 0; p < gathering_.persons(); ++p)
      for (const std::string& n : gathering_.notes(p)) s += "person " + std::to_string(p) + ": " + n + "\n";
    return s;
  }

 private:
  int founders_;
  lab::Gathering gathering_;
  lab::Judge judge_;
};

}  // namespace padr::test
