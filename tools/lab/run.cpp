#include "tools/lab/run.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include <unistd.h>

#include "common/model/user_error.h"
#include "shell/command_line.h"
#include "shell/files.h"
#include "shell/revision.h"
#include "shell/run_main.h"
#include "tools/lab/run_summary.h"

namespace padr::lab {
namespace {

constexpr double kMaxSeconds = 24 * 3600;

using WallClock = std::chrono::steady_clock;

double seconds_since(WallClock::time_point start) {
  return std::chrono::duration<double>(WallClock::now() - start).count();
}

/// A line on standard error that says how far a long run is; nothing when it is not a terminal or the run is short.
class Progress {
 public:
  explicit Progress(Tick all) : all_(all), shown_(isatty(2) != 0) {}
  void at(Tick now) {
    const double spent = seconds_since(start_);
    if (!shown_ || spent < next_) return;
    next_ = spent + 0.5;
    const double left = spent * static_cast<double>(all_ - now) / static_cast<double>(now);
    std::fprintf(stderr, "\r%3d %%, %.0f s left   ", static_cast<int>(100.0 * now / all_), left);
    drawn_ = true;
  }
  ~Progress() {
    if (drawn_) std::fputs("\r\033[K", stderr);
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

 private:
  Tick all_;
  bool shown_;
  bool drawn_ = false;
  double next_ = 1;
  WallClock::time_point start_ = WallClock::now();
};

}  // namespace

void RunCommand::declare(CLI::App& app) {
  scenario_.declare(app);
  app.add_option("--peers", peers_, "Peers, each with its own world and avatar")
      ->check(shell::range(1, kMaxPeers))
      ->capture_default_str();
  app.add_option("--slots", slots_, "Avatar slots of the session; default: the number of peers")
      ->check(shell::range(1, kMaxPeers));
  app.add_option("--seconds", seconds_, "Virtual time with input")->check(shell::range(0.1, kMaxSeconds));
  app.add_option("--settle", settle_seconds_, "Virtual seconds without input after that")
      ->check(shell::range(0.0, kMaxSeconds))
      ->capture_default_str();
  app.add_option("--input", inputs_, std::string(shell::kInputHelp) + "; repeat for more peers, in turn")
      ->type_name("SPEC");
  netem_.declare(app);
  technique_.declare(app);
  app.add_option("--fidelity", fidelity_,
                 "Measure fidelity and physics-consistency-cost (docs/metrics.md defines them): on or off")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  app.add_option(
         "--watch", watch_,
         "Inconsistency in the view of this peer alone, and only while there is input; all else over the whole run")
      ->type_name("PEER")
      ->check(shell::range(0, kMaxPeers - 1));
  app.add_option("--json", json_, "Write the summary as JSON to a file, or - for standard output in place of the table")
      ->type_name("FILE|-");
  app.add_option("--csv", series_, "Write inconsistency and fidelity of every peer at every tick as CSV")
      ->type_name("FILE|-");
  app.add_option("--trace", trace_dir_, "Write one trace per peer into this folder, for padr-report and replay")
      ->type_name("DIR");
  app.footer(
      "Example:\n"
      "  padr-lab run --scenario arena --peers 4 --technique full --threshold 0.3:0.1 --body-threshold 0.05 \\\n"
      "    --netem \"delay 100ms 50ms loss 10%\" --seconds 60 --seed 3 --json -\n"
      "Exit: 0 done, 1 confirmed worlds differed or a file could not be written, 2 usage.");
}

void RunCommand::prepare_outputs(const shell::LoadedScenario& scenario, const std::vector<std::string>& command,
                                 SimulationConfig& config) {
  shell::check_writable("--csv", series_);
  shell::check_writable("--json", json_);
  if (trace_dir_.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(trace_dir_, error);
  if (error) throw UserError("--trace: cannot make the folder " + trace_dir_ + ": " + error.message());
  for (int p = 0; p < peers_; ++p) {
    auto file = std::make_shared<shell::OutputFile>("--trace", trace_dir_ + "/peer" + std::to_string(p) + ".trace",
                                                    shell::Readers::kAsUsual, shell::Content::kBinary);
    node::RecordedReplica::Recording r;
    r.provenance.program = "padr-lab";
    r.provenance.revision = std::string(shell::revision());
    r.provenance.command = command;
    r.provenance.scenario = scenario.label;
    r.provenance.scenario_text = scenario.text;
    r.provenance.scenario_seed = scenario.seed;
    r.provenance.netem = netem_.text();
    r.provenance.netem_seed = config.netem_seed;
    r.provenance.input = inputs_[static_cast<std::size_t>(p) % inputs_.size()];
    r.sink = [file](std::span<const std::byte> bytes) { file->write(bytes); };
    config.recordings.emplace_back(std::move(r));
  }
}

int RunCommand::run(const std::vector<std::string>& command) {
  const shell::LoadedScenario scenario = scenario_.load();
  const auto spawns = static_cast<int>(scenario.scene.avatar.spawns.size());
  if (std::max(peers_, slots_) > spawns)
    throw UserError("--peers: " + std::to_string(std::max(peers_, slots_)) + " is too many for scenario " +
                    scenario.label + ", which has room for " + std::to_string(spawns));
  if (slots_ != 0 && slots_ < peers_)
    throw UserError("--slots: " + std::to_string(slots_) + " is less than --peers " + std::to_string(peers_));
  shell::refuse_surplus_inputs(inputs_, peers_);
  if (watch_ >= peers_)
    throw UserError("--watch: '" + std::to_string(watch_) + "' is not allowed; give 0 to " +
                    std::to_string(peers_ - 1));
  SimulationConfig config;
  std::vector<std::string> warnings;
  config.scene = scenario.scene;
  config.peers = peers_;
  config.slots = slots_;
  config.fidelity = fidelity_ == "on";
  config.technique = technique_.technique();
  config.netem = netem_.spec(&warnings);
  config.netem_seed = netem_.seed(scenario.seed);
  config.ticks = static_cast<Tick>(std::lround(seconds_ * kTicksPerSecond));
  config.settle_ticks = static_cast<Tick>(std::lround(settle_seconds_ * kTicksPerSecond));
  for (const std::string& w : warnings) std::cerr << "padr-lab: warning: " << w << '\n';
  if (inputs_.empty()) inputs_.emplace_back("wander");
  std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
  for (int p = 0; p < peers_; ++p) {
    const std::string& spec = inputs_[static_cast<std::size_t>(p) % inputs_.size()];
    inputs.push_back(shell::load_input(spec, scenario.scene, p, scenario.seed));
    config.inputs.push_back(inputs.back().get());
  }
  shell::tell_of_paths("padr-lab", inputs_, scenario.scene);
  prepare_outputs(scenario, command, config);

  RunFacts facts{command, scenario.label, netem_.text(), inputs_, scenario.seed, config.netem_seed, config.technique,
                 0,       std::nullopt};
  if (watch_ >= 0) facts.watched = static_cast<PeerId>(watch_);
  const Tick all = config.ticks + config.settle_ticks;
  const auto start = WallClock::now();
  Simulation simulation(std::move(config));
  {
    Progress progress(all);
    simulation.run([&progress](Tick now) { progress.at(now); });
  }
  facts.wall_seconds = seconds_since(start);
  simulation.finish();
  if (Simulation::is_little(simulation.measured_share(), all))
    std::fprintf(
        stderr,
        "padr-lab: warning: inconsistency was measured at the first %.0f %% of ticks only: the others were not "
        "confirmed in time; --settle plays on without input\n",
        100 * simulation.measured_share());

  if (!series_.empty()) shell::write_text("--csv", series_, csv_series(simulation));
  if (!json_.empty()) shell::write_text("--json", json_, json_summary(simulation, facts));
  if (json_ != "-" && series_ != "-") std::cout << table_summary(simulation, facts);
  return simulation.confirmed_mismatches() == 0 ? shell::kExitFine : shell::kExitFailure;
}

}  // namespace padr::lab
