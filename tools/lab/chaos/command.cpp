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

/// Violations for which the shortest script is searched.
constexpr int kMostShrunk = 3;
/// Of as many scripts or fewer each gets its line.
constexpr int kMostLines = 40;
/// Peers of a script with a liar.
constexpr int kLeastWithLiar = 4;
constexpr int kMostWithLiar = 8;

std::string seconds(double s) {
  return shell::fixed(s, 2);
}

/// Of the line of a script; empty if nobody lies in it.
std::string liar_of(const ChaosScript& script, const ChaosOutcome& o) {
  if (!script.liar) return "";
  return "liar " + std::string(script.liar->how->name) + (o.led_by_liar ? " (as coordinator, too)" : "") + ", ";
}

}  // namespace

void ChaosCommand::declare(CLI::App& app) {
  app.add_option("--seed", seed_, "Seed of the first run; the others have the following seeds")->capture_default_str();
  app.add_option("--runs", runs_, "Scripts to play, one for each seed")
      ->check(shell::range(1, 1000000))
      ->capture_default_str();
  app.add_option("--minutes", minutes_, "Virtual length of a script; quiet follows")
      ->check(shell::range(0.1, 600.0))
      ->capture_default_str();
  peers_option_ = app.add_option("--peers", peers_, "Most peers at once; with --liar 8 unless given")
                      ->check(shell::range(2, kMaxPeers))
                      ->capture_default_str();
  app.add_option("--scenario", scenario_, "Built-in name or file")->type_name("NAME|FILE")->capture_default_str();
  app.add_option("--bodies", bodies_, "Bodies of the scenario")->check(shell::range(1, 5000))->capture_default_str();
  technique_.declare(app);
  app.add_flag_callback(
      "--sealed", [this] { how_.seal = wire::SealMode::kAuth; }, "Sessions have a key");
  app.add_flag("--cuts", cuts_,
               "Links between two peers fail, too, in one direction or both, for a while or again and again");
  app.add_flag("--spectators", how_.spectators, "Some peers have no avatar");
  liar_option_ = app.add_option("--liar", liar_name_,
                                "One of 4 peers or more lies; implies --sealed. The behaviour is "
                                "drawn for each script, unless it is named")
                     ->expected(0, 1)
                     ->type_name("[NAME]");
  app.add_option("--jobs", jobs_, "Runs at once; default: one for each processor")->check(shell::range(1, 1024));
  app.add_option("--shrink", shrink_tries_, "Scripts to try for the shortest one that shows a violation; 0: none")
      ->check(shell::range(0, 10000))
      ->capture_default_str();
  app.add_flag("--story", story_, "Also print every script and the events at each peer");
  app.add_option("--json", json_, "Results to a file, or - for standard output in place of the table")
      ->type_name("FILE|-");
  app.footer(
      "Peers found a session. By a random script other peers then join, leave, crash and pause; some machines are\n"
      "suspended, with their clocks, and may wake in another network; the network splits, links change, and all\n"
      "avatars move to one place. Clocks run wrong by up to 200 ppm, and the peers steer them. Checks at every tick:\n"
      "peers that are members to each other have confirmed the same worlds, bit by bit; a body has at most one owner,\n"
      "and that owner is there; all numbers are finite; memory is bounded. After the script and 20 s of quiet, 50 s\n"
      "with --liar, all running peers must be in one session and know each other. If a check fails, the program\n"
      "prints the shortest script that still shows the failure.\n"
      "With --liar one of the peers lies now and then, with its own keys; the checks are for the honest among\n"
      "themselves. Harm must be mended within 30 s: a peer that confirms nothing or is out, two that confirm\n"
      "different worlds. Nobody honest may be cut off, and no live world may stand still for 1 s. Those whom the liar\n"
      "alone has let in, into a session that nobody else knows of, only have to agree among themselves. Behaviours:\n" +
      help_on_behaviours() +
      "Example:\n"
      "  padr-lab chaos --seed 1 --runs 20 --minutes 2\n"
      "Exit: 0 all checks passed, 1 a check failed or a file could not be written, 2 usage.");
}

// Of the run's own seed, so that a run by itself is the same as among many.
ChaosPlay ChaosCommand::how_of(std::size_t i) const {
  ChaosPlay how = how_;
  const shell::LoadedScenario scenario = shell::load_scenario(scenario_, seed_ + i);
  how.scene = scenarios::load(scenarios::with_bodies(scenario.text, scenario_, bodies_), scenario_, seed_ + i);
  return how;
}

void ChaosCommand::prepare_liar() {
  lies_ = liar_option_->count() > 0;
  if (!lies_) return;
  if (how_.seal == wire::SealMode::kNone) how_.seal = wire::SealMode::kAuth;
  how_.quiet += how_.bounds.out;  // so long what the last lie does may last
  if (peers_option_->count() == 0) peers_ = kMostWithLiar;
  if (peers_ < kLeastWithLiar)
    throw UserError("--peers: " + std::to_string(peers_) + " is too few with --liar, which takes " +
                    std::to_string(kLeastWithLiar) + " to " + std::to_string(kMaxPeers));
  if (liar_name_.empty() || liar_name_ == "true") return;
  liar_ = behaviour(liar_name_);
  if (liar_ == nullptr) throw UserError("--liar: there is no behaviour '" + liar_name_ + "'; --help lists them");
}

void ChaosCommand::prepare() {
  prepare_liar();
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
    if (const ChaosScript script = script_of(i); script.liar) {
      j.field("liar", script.liar->how->name).field("led_by_liar", o.led_by_liar).field("lies", o.lies);
      tell_harm(o.harm, o.differed, j);
    } else {
      j.field("evicted", o.harm.evicted).field("evicted_reachable", o.harm.evicted_reachable);
    }
    j.field("violation", o.violation).end_object();
  }
  j.end_array();
  if (lies_) harm(outcomes).tell(j.key("behaviours"));
  j.end_object();
  return j.text();
}

void ChaosCommand::print(std::size_t i, const ChaosOutcome& o, bool shrinks) const {
  const ChaosScript script = script_of(i);
  const bool held = o.violation.empty();
  if (story_ || runs_ <= kMostLines || !held)
    std::cout << "seed " << script.seed << ": " << liar_of(script, o) << o.peers << " peers, " << o.incarnations
              << " lives, " << o.compared << " hashes compared, slowest join " << seconds(o.slowest_join)
              << " s: " << (held ? "held" : "VIOLATED " + o.violation) << '\n';
  if (story_) {
    std::cout << describe(script);
    for (const std::string& line : o.story) std::cout << "  " << line << '\n';
  }
  if (held || !shrinks) return;
  const ChaosPlay how = how_of(i);
  const ChaosScript shortest = shrink(how, script, shrink_tries_);
  std::cout << "shortest script found: " << describe(shortest) << "  then: " << play(how, shortest).violation << '\n';
}

ChaosScript ChaosCommand::script_of(std::size_t i) const {
  const auto length = static_cast<Micros>(std::llround(minutes_ * 60e6));
  ChaosScript script = make_script(seed_ + i, length, peers_, lies_ ? kLeastWithLiar : 2);
  if (cuts_) script = with_cuts(std::move(script));
  return lies_ ? with_liar(std::move(script), liar_) : script;
}

HarmTable ChaosCommand::harm(const std::vector<ChaosOutcome>& outcomes) const {
  HarmTable table;
  for (std::size_t i = 0; i < outcomes.size(); ++i)
    if (const ChaosScript script = script_of(i); script.liar) table.add(script.liar->how->name, outcomes[i]);
  return table;
}

std::string ChaosCommand::summary(const std::vector<ChaosOutcome>& outcomes) const {
  std::uint64_t compared = 0;
  double slowest = 0;
  std::ptrdiff_t bad = 0;
  int evicted = 0;
  int reachable = 0;
  for (const ChaosOutcome& o : outcomes) {
    evicted += o.harm.evicted;
    reachable += o.harm.evicted_reachable;
    compared += o.compared;
    slowest = std::max(slowest, o.slowest_join);
    if (!o.violation.empty()) ++bad;
  }
  return std::to_string(outcomes.size()) + " scripts, seeds " + std::to_string(seed_) + " to " +
         std::to_string(seed_ + outcomes.size() - 1) + ", " + std::to_string(compared) +
         " hashes compared, slowest join " + seconds(slowest) + " s, " + std::to_string(evicted) +
         " evicted while they ran (" + std::to_string(reachable) + " of them reachable): " + std::to_string(bad) +
         " violations\n" + harm(outcomes).text();
}

int ChaosCommand::run(const std::vector<std::string>& command) {
  prepare();
  shell::check_writable("--json", json_);
  ParallelOptions options;
  options.threads = jobs_;
  options.what = "scripts";
  const auto outcomes = parallel_results<ChaosOutcome>(
      static_cast<std::size_t>(runs_), [&](std::size_t i) { return play(how_of(i), script_of(i)); }, options);
  int bad = 0;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    if (!outcomes[i].violation.empty()) ++bad;
    if (json_ != "-") print(i, outcomes[i], bad <= kMostShrunk && shrink_tries_ > 0);
  }
  if (json_ != "-") std::cout << summary(outcomes);
  if (!json_.empty()) shell::write_text("--json", json_, json(command, outcomes));
  return bad == 0 ? shell::kExitFine : shell::kExitFailure;
}

}  // namespace padr::lab
