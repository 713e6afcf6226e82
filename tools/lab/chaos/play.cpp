#include "tools/lab/chaos/play.h"

#include <algorithm>
#include <limits>

#include "common/model/rng.h"
#include "shell/netem_text.h"
#include "tools/lab/chaos/liar_part.h"
#include "tools/lab/testbed/judge.h"

namespace padr::lab {
namespace {

using Kind = ChaosEvent::Kind;

/// Does what a script says, and undoes what lasts only for a while.
class Stage {
 public:
  Stage(VirtualNetwork& g, const Scene& scene) : network_(g), scene_(scene) {}

  void act(const ChaosEvent& e) {
    const std::vector<int> there = those_there();
    if (there.empty()) return;
    const int who = there[e.pick % there.size()];
    const int other = there[(e.pick >> 20U) % there.size()];
    switch (e.kind) {
      case Kind::kStart:
        if (const std::vector<int> known = those_that_stay(there); !known.empty())
          network_.start(known[e.pick % known.size()]);
        return;
      case Kind::kLeave:
        if (there.size() > 1) network_.leave(who);
        return;
      case Kind::kKill:
        if (there.size() > 1) network_.kill(who);
        return;
      case Kind::kPause:
        if (e.suspends() && !network_.paused(who)) suspended_[who] = {network_.now(), e.moves()};
        network_.pause(who, true);
        undo_.push_back({e.at + e.span, Kind::kPause, who});
        return;
      case Kind::kDivide: {
        std::map<int, int> sides;
        for (int p = 0; p < network_.persons(); ++p) sides[p] = static_cast<int>(e.pick >> (p % 60) & 1U);
        network_.divide(std::move(sides));
        undo_.push_back({e.at + e.span, Kind::kDivide, 0});
        return;
      }
      case Kind::kShape:
        network_.shape(shell::parse_netem(chaos_links()[e.pick % chaos_links().size()]));
        return;
      case Kind::kFight: {
        const double x = static_cast<double>(e.pick & 0xFFFFU) / 65536;
        const double y = static_cast<double>(e.pick >> 16U & 0xFFFFU) / 65536;
        network_.attract(Vec2{static_cast<float>(scene_.lower.x + x * (scene_.upper.x - scene_.lower.x)),
                              static_cast<float>(scene_.lower.y + y * (scene_.upper.y - scene_.lower.y))});
        undo_.push_back({e.at + e.span, Kind::kFight, 0});
        return;
      }
      case Kind::kCut:
        cut(who, other, e.at + e.span);
        if (e.pick >> 40U & 1U) cut(other, who, e.at + e.span);
        return;
    }
  }

  /// When something is to be undone next; the end of time if nothing is.
  Micros next_undo() const {
    Micros t = std::numeric_limits<Micros>::max();
    for (const Undo& u : undo_) t = std::min(t, u.at);
    return t;
  }
  void undo_until(Micros t) {
    for (const Undo& u : undo_) {
      if (u.at > t) continue;
      if (u.kind == Kind::kPause) wake(u.who);
      if (u.kind == Kind::kDivide) network_.divide({});
      if (u.kind == Kind::kFight) network_.attract({});
      if (u.kind == Kind::kCut) network_.cut(u.who, u.other, false);
    }
    std::erase_if(undo_, [t](const Undo& u) { return u.at <= t; });
  }

 private:
  struct Undo {
    Micros at;
    Kind kind;
    int who;
    int other = 0;
  };
  /// A place where nobody has been.
  Endpoint elsewhere() { return ipv4({192, 0, 2, 7}, ++moved_); }
  // At the end of a script sooner than planned.
  void wake(int who) {
    if (const auto it = suspended_.find(who); it != suspended_.end()) {
      network_.stand_still(who, network_.now() - it->second.since);
      if (it->second.moves) network_.move(who, elsewhere());
      suspended_.erase(it);
    }
    network_.pause(who, false);
  }
  void cut(int from, int to, Micros until) {
    if (from == to) return;
    network_.cut(from, to, true);
    undo_.push_back({until, Kind::kCut, from, to});
  }
  // The address of a machine that will wake up elsewhere leads nowhere, and a newcomer knows only one.
  std::vector<int> those_that_stay(std::vector<int> there) const {
    std::erase_if(there, [&](int p) {
      const auto it = suspended_.find(p);
      return it != suspended_.end() && it->second.moves;
    });
    return there;
  }
  std::vector<int> those_there() const {
    std::vector<int> there;
    for (int p = 0; p < network_.persons(); ++p)
      if (network_.runs(p) && !network_.leaving(p) && network_.peer(p).playing()) there.push_back(p);
    return there;
  }

  VirtualNetwork& network_;
  const Scene& scene_;
  std::vector<Undo> undo_;
  struct Suspended {
    Micros since;
    bool moves;
  };
  std::map<int, Suspended> suspended_;
  std::uint16_t moved_ = 0;  ///< machines that have moved
};

void fill_outcome(const VirtualNetwork& g, const ChaosPlay& how, int founders, ChaosOutcome& out) {
  out.peers = g.persons();
  for (int p = 0; p < g.persons(); ++p) {
    out.incarnations += g.peer(p).incarnation() + 1;
    if (p >= founders) out.slowest_join = std::max(out.slowest_join, static_cast<double>(g.took(p)) / 1e6);
    if (!how.story) continue;
    for (const std::string& n : g.notes(p)) out.story.push_back(n + "  (person " + std::to_string(p) + ")");
  }
  std::sort(out.story.begin(), out.story.end(),
            [](const std::string& a, const std::string& b) { return std::stod(a) < std::stod(b); });
}

}  // namespace

namespace {

VirtualNetworkConfig config_of(const ChaosPlay& how, const ChaosScript& script) {
  VirtualNetworkConfig config;
  config.scene = how.scene;
  config.technique = how.technique;
  config.netem = shell::parse_netem(chaos_links().front());
  config.seed = script.seed;
  config.slots = how.slots;
  config.seal = how.seal;
  config.recording = how.recording;
  config.wanted = script.founders;
  config.most_ppm = 200;                   // as much as cheap quartz is off
  config.refusals = script.seed % 2 == 1;  // some networks tell, some do not
  if (!how.spectators) return config;
  const bool founder = script.founders >= 3 && script.seed % 3 == 0;
  if (founder) --config.wanted;
  config.spectates = [founder, seed = script.seed, founders = script.founders](int person) {
    if (person < founders) return person == 0 && founder;
    return derive_seed(seed, 0x5BEC, static_cast<std::uint64_t>(person)) % 3 == 0;
  };
  return config;
}

/// A script in progress.
class Performance {
 public:
  Performance(const ChaosPlay& how, const ChaosScript& script)
      : how_(how),
        script_(script),
        network_(config_of(how, script)),
        judge_(network_),
        stage_(network_, how.scene),
        meter_(network_, judge_.liars(), how.bounds) {
    if (script.liar) liar_.emplace(network_, judge_, script);
    if (script.liar) judge_.tolerate_differences(how.differ);
  }

  void play() {
    network_.start({});
    for (int p = 1; p < script_.founders; ++p) network_.start(0);
    for (const ChaosEvent& e : script_.events) {
      run_to(e.at);
      if (!holds()) return;
      stage_.undo_until(e.at);
      stage_.act(e);
    }
    run_to(script_.length);
    if (!holds()) return;
    stage_.undo_until(std::numeric_limits<Micros>::max());
    network_.shape(shell::parse_netem(chaos_links().front()));
    run_to(script_.length + how_.quiet);
    if (holds()) judge_.final_check();
  }

  ChaosOutcome outcome() const {
    ChaosOutcome out;
    out.violation = violation();
    out.compared = judge_.compared();
    out.harm = meter_.harm();
    out.harm.kept_out += judge_.held_apart();
    out.differed = judge_.longest_difference();
    if (liar_) {
      out.lies = liar_->told();
      out.led_by_liar = liar_->led();
    }
    fill_outcome(network_, how_, script_.founders, out);
    return out;
  }

 private:
  // Bounds on harm are for where somebody lies: without a lie, networks alone may do worse.
  const std::string& violation() const {
    return judge_.violation().empty() && liar_ ? meter_.violation() : judge_.violation();
  }
  bool holds() const { return violation().empty(); }
  void run_to(Micros t) {
    while (holds() && network_.now() < t) {
      stage_.undo_until(network_.now());
      network_.run_to(std::min({t, stage_.next_undo(), network_.now() + HarmMeter::kEvery}));
      if (liar_) liar_->advance();
      meter_.look();
    }
  }

  const ChaosPlay& how_;
  const ChaosScript& script_;
  VirtualNetwork network_;
  Judge judge_;
  Stage stage_;
  HarmMeter meter_;
  std::optional<LiarPart> liar_;
};

}  // namespace

ChaosOutcome play(const ChaosPlay& how, const ChaosScript& script) {
  Performance performance(how, script);
  performance.play();
  return performance.outcome();
}

}  // namespace padr::lab
