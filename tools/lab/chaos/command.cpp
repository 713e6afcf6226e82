#include "tools/lab/chaos/command.h"

#include <algorithm>
#include <cmath>
#include <iostream>

#include "common/model/user_error.h"
#include "common/scenarios/bodies.h"
#include "common/scenarios/scenarios.h"
#include "shell/command_line.h"
#include "shell/files.h"
#include "shell/json.h"
#include "shell/revision.h"
#include "shell/run_main.h"
#include "shell/scenario_flags.h"
#include "shell/text.h"
#include "tools/lab/chaos/shrink.h"
#include "tools/lab/parallel.h"

namespace padr::lab {
namespace {

constexpr int kShrinkTries = 200;
/// Violations for which the shortest script is searched.
constexpr int kMostShrunk = 3;
/// Of as many scripts or fewer each gets its line.
constexpr int kMostLines = 40;

std::string seconds(double s) {
  return shell::fixed(s, 2);
}

}  // namespace

void ChaosCommand::declare(CLI::App& app) {
  app.add_option("--seed", seed_, "Seed of the first run; the others have the following seeds")->capture_default_str();
  app.add_option("--runs", runs_, "Scripts to play, one for each seed")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--minutes", minutes_, "Virtual length of a script; 20 s of quiet follow")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  app.add_option("--peers", peers_, "Most peers at once")->check(CLI::Range(2, kMaxPeers))->capture_default_str();
  app.add_option("--scenario", scenario_, "Built-in name or file")->type_name("NAME|FILE")->capture_default_str();
  app.add_option("--bodies", bodies_, "Bodies of the scenario")->check(CLI::Range(1, 5000))->capture_default_str();
  technique_.declare(app);
  app.add_flag_callback(
      "--sealed", [this] { how_.seal = wire::SealMode::kAuth; }, "Sessions have a key");
  app.add_option("--jobs", jobs_, "Runs at once; default: one for each processor")->check(CLI::Range(1, 1024));
  app.add_flag("--story", story_, "Also print every script and the events at each peer");
  app.add_option("--json", json_, "Results to a file, or - for standard output in place of the table")
      ->type_name("FILE|-");
  app.footer(
      "Peers found a session. By a random script other peers then join, leave, crash and pause; the network splits,\n"
      "links change, and all avatars move to one place. Clocks run wrong by up to 200 ppm, and the peers steer them.\n"
      "Checks at every tick: peers that are members to each other have confirmed the same worlds, bit by bit; a body\n"
      "has at most one owner, and that owner is there; all numbers are finite; memory is bounded. After the script "
      "and\n"
      "20 s of quiet all running peers must be in one session and know each other. If a check fails, the program\n"
      "prints the shortest script that still shows the failure.\n"
      "Example:\n"
      "  padr-lab chaos --seed 1 --runs 20 --minutes 2\n"
      "Exit: 0 all checks passed, 1 a check failed, 2 usage.");
}

// Of the run's own seed, so that a run by itself is the same as among many.
ChaosPlay ChaosCommand::how_of(std::size_t i) const {
  ChaosPlay how = how_;
  const shell::LoadedScenario scenario = shell::load_scenario(scenario_, seed_ + i);
  how.scene = scenarios::load(scenarios::with_bodies(scenario.text, scenario_, bodies_), scenario_, seed_ + i);
  return how;
}

void ChaosCommand::prepare() {
  const auto spawns = static_cast<int>(how_of(0).scene.avatar.spawns.size());
  if (peers_ > spawns)
    throw UserError("--peers: " + std::to_string(peers_) + " is too many for scenario " + scenario_ +
                    ", which has room for " + std::to_string(spawns));
  how_.slots = std::min(spawns, peers_ + peers_ / 2);  // who comes back does so before its old place is free
  how_.technique = technique_.technique();
  how_.story = story_;
}

std::string ChaosCommand::json(const std::vector<std::string>& command,
                               const std::vector<ChaosOutcome>& outcomes) const {
  shell::Json j;
  j.begin_object().field("command", shell::shell_line(command)).field("revision", shell::revision());
  j.key("runs").begin_array();
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const ChaosOutcome& o = outcomes[i];
    j.begin_object().field("seed", seed_ + i).field("peers", o.peers).field("lives", o.incarnations);
    j.field("hashes_compared", o.compared).field("slowest_join_s", o.slowest_join);
    j.field("violation", o.violation).end_object();
  }
  j.end_array().end_object();
  return j.text();
}

void ChaosCommand::print(std::size_t i, const ChaosOutcome& o) const {
  const ChaosScript script = script_of(i);
  const bool held = o.violation.empty();
  if (story_ || runs_ <= kMostLines || !held)
    std::cout << "seed " << script.seed << ": " << o.peers << " peers, " << o.incarnations << " lives, " << o.compared
              << " hashes compared, slowest join " << seconds(o.slowest_join)
              << " s: " << (held ? "held" : "VIOLATED " + o.violation) << '\n';
  if (story_) {
    std::cout << describe(script);
    for (const std::string& line : o.story) std::cout << "  " << line << '\n';
  }
  if (held) return;
  const ChaosPlay how = how_of(i);
  const ChaosScript shortest = shrink(how, script, kShrinkTries);
  std::cout << "shortest script found: " << describe(shortest) << "  then: " << play(how, shortest).violation << '\n';
}

ChaosScript ChaosCommand::script_of(std::size_t i) const {
  return make_script(seed_ + i, static_cast<Micros>(std::llround(minutes_ * 60e6)), peers_);
}

int ChaosCommand::run(const std::vector<std::string>& command) {
  prepare();
  ParallelOptions options;
  options.threads = jobs_;
  options.what = "scripts";
  const auto outcomes = parallel_results<ChaosOutcome>(
      static_cast<std::size_t>(runs_), [&](std::size_t i) { return play(how_of(i), script_of(i)); }, options);
  std::uint64_t compared = 0;
  int bad = 0;
  double slowest = 0;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const ChaosOutcome& o = outcomes[i];
    compared += o.compared;
    slowest = std::max(slowest, o.slowest_join);
    if (!o.violation.empty()) ++bad;
    if (json_ != "-" && (o.violation.empty() || bad <= kMostShrunk)) print(i, o);
  }
  if (json_ == "-") {
    std::cout << json(command, outcomes);
  } else {
    std::cout << outcomes.size() << " scripts, seeds " << seed_ << " to " << seed_ + outcomes.size() - 1 << ", "
              << compared << " hashes compared, slowest join " << seconds(slowest) << " s: " << bad << " violations\n";
    if (!json_.empty()) {
      shell::OutputFile file("--json", json_);
      file.write(json(command, outcomes));
      file.close();
    }
  }
  return bad == 0 ? shell::kExitFine : shell::kExitFailure;
}

}  // namespace padr::lab
