#include "tools/lab/convergence/command.h"

#include <fmt/printf.h>

#include <cmath>
#include <iostream>

#include "common/model/user_error.h"
#include "shell/command_line.h"
#include "shell/run_main.h"
#include "tools/lab/convergence/film.h"
#include "tools/lab/rates.h"
#include "tools/plot/svg.h"

namespace padr::lab {
namespace {

using namespace convergence;

std::string table(const Takes& takes) {
  std::string out =
      "         inconsistency (m)   snaps: jumps by over 3 cm     step changes, m/s   overshoot, m     overlap, m      "
      "freezes\n"
      "method   live  shown   peak  per second  mean m  largest m    all  unexplained   mean   peak   mean   made    "
      "per "
      "second\n";
  for (std::size_t m = 0; m < kMethods.size(); ++m) {
    const Simulation& s = *takes.simulations[m];
    const trace::Inconsistency i = s.meter().overall();
    const Rates r = rates_of(s, 0, s.peers());
    const trace::ShownMotion& q = r.shown;
    out += fmt::sprintf("%-6s  %5.3f  %5.3f  %5.2f      %6.2f  %6.3f     %6.2f  %5.2f        %5.2f", kNames[m],
                        i.mean_m, i.shown_mean_m, i.shown_peak_m, r.snaps, r.snaps > 0 ? r.snap_m / r.snaps : 0.0,
                        r.snap_peak_m, q.stride_change_m_per_s(), q.unexplained_m_per_s());
    out += fmt::sprintf("  %5.3f  %5.3f  %5.4f  %5.4f  %10.2f\n", q.overshoot_mean_m(), q.overshoot_peak_m,
                        q.overlap_mean_m(), q.overlap_made_mean_m(), q.freezes_per_s());
  }
  return out;
}

std::string csv(const Takes& takes) {
  std::string out =
      "method,mean_m,shown_mean_m,shown_peak_m,snaps_per_s,snap_m_per_s,snap_peak_m,stride_change_m_per_s,"
      "stride_unexplained_m_per_s,stops,overshoot_mean_m,overshoot_peak_m,overlap_mean_m,overlap_made_mean_m,"
      "overlap_peak_m,freezes_per_s,longest_freeze_s\n";
  for (std::size_t m = 0; m < kMethods.size(); ++m) {
    const Simulation& s = *takes.simulations[m];
    const trace::Inconsistency i = s.meter().overall();
    const Rates r = rates_of(s, 0, s.peers());
    out += kNames[m];
    const trace::ShownMotion& q = r.shown;
    for (const double v :
         {i.mean_m, i.shown_mean_m, i.shown_peak_m, r.snaps, r.snap_m, r.snap_peak_m, q.stride_change_m_per_s(),
          q.unexplained_m_per_s(), static_cast<double>(q.stops), q.overshoot_mean_m(), q.overshoot_peak_m,
          q.overlap_mean_m(), q.overlap_made_mean_m(), q.overlap_peak_m, q.freezes_per_s(), q.longest_freeze_s()})
      out += "," + plot::number(v);
    out += "\n";
  }
  return out;
}

}  // namespace

void ConvergenceCommand::declare(CLI::App& app) {
  constexpr double kMaxSeconds = 600;
  scenario_.declare(app);
  app.add_option("--peers", peers_, "Peers")->check(shell::range(2, kMaxPeers))->capture_default_str();
  app.add_option("--seconds", seconds_, "Virtual length, s")
      ->check(shell::range(1.0, kMaxSeconds))
      ->capture_default_str();
  netem_.declare(app);
  app.add_option("--out", out_, "Folder for convergence.csv, film-convergence.svg and .png")
      ->type_name("DIR")
      ->required();
  app.footer(
      "Plays one session of technique full with wandering avatars four times. The simulations are the same to the "
      "bit;\n"
      "only the shown positions differ. The film has the largest correction of an avatar and of a body in the view of\n"
      "peer 1, up to 1.2 m.\n"
      "Example:\n"
      "  padr-lab convergence --netem \"delay 100ms 30ms loss 2%\" --out out/convergence\n"
      "Exit: 0 done, 2 usage.");
}

int ConvergenceCommand::run() {
  const shell::LoadedScenario scenario = scenario_.load();
  const auto room = static_cast<int>(scenario.scene.avatar.spawns.size());
  if (peers_ > room)
    throw UserError("--peers: " + std::to_string(peers_) + " is too many for scenario " + scenario.label +
                    ", which has room for " + std::to_string(room));
  SimulationConfig config;
  std::vector<std::string> warnings;
  config.scene = scenario.scene;
  config.peers = peers_;
  config.netem = netem_.spec(&warnings);
  config.netem_seed = netem_.seed(scenario.seed);
  config.ticks = static_cast<Tick>(std::lround(seconds_ * kTicksPerSecond));
  for (const std::string& w : warnings) std::cerr << "padr-lab: warning: " << w << '\n';
  std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
  for (int p = 0; p < peers_; ++p) {
    inputs.push_back(shell::load_input("wander", scenario.scene, p, scenario.seed));
    config.inputs.push_back(inputs.back().get());
  }
  plot::write_into("--out", out_, {});
  Takes takes(config, 1);
  takes.run();
  std::cout << table(takes);
  plot::write_into("--out", out_,
                   {{"convergence.csv", csv(takes)}, plot::film_svg(film_of(takes.footage, scenario.scene))});
  const std::string wrong = plot::rasterize(out_, {"film-convergence"});
  if (!wrong.empty()) std::cerr << "padr-lab: " << wrong << '\n';
  return shell::kExitFine;
}

}  // namespace padr::lab
