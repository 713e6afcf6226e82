#include "tools/lab/compare/plan_flags.h"

#include <cmath>
#include <iostream>
#include <sstream>

#include "common/model/user_error.h"
#include "shell/command_line.h"
#include "shell/netem_flags.h"
#include "shell/scenario_flags.h"
#include "tools/lab/compare/alternative_text.h"

namespace padr::lab::compare {
namespace {

/// Rows of two with one name could not be told apart.
template <typename All, typename NameOf>
void refuse_second(const std::string& flag, const std::string& text, const All& all, const NameOf& name_of) {
  for (std::size_t i = 0; i + 1 < all.size(); ++i)
    if (name_of(all[i]) == name_of(all.back()))
      throw UserError(flag + ": '" + text + "' is played already; give every one once");
}

std::string with_single_spaces(const std::string& text) {
  std::istringstream words(text);
  std::string out;
  for (std::string word; words >> word;) out += (out.empty() ? "" : " ") + word;
  return out;
}

constexpr double kMaxSeconds = 24 * 3600;

}  // namespace

std::string help_on_contestants() {
  std::string text = "Techniques:\n";
  for (const Contestant& c : all_contestants())
    text += "  " + c.id + std::string(c.id.size() < 23 ? 23 - c.id.size() : 1, ' ') + c.what + "\n";
  return text + "Alternatives with their knobs, for --add:\n" + help_on_alternatives();
}

void PlanFlags::declare(CLI::App& app) {
  std::string usual;
  for (const std::string& n : usual_.networks) usual += (usual.empty() ? "'" : ", '") + n + "'";
  app.add_option("--scenario", scenario_, "Built-in name, or a file")->type_name("NAME|FILE")->capture_default_str();
  app.add_option("--peers", peers_, "Peers")->check(shell::range(1, kMaxPeers))->capture_default_str();
  app.add_option("--seconds", seconds_, "Virtual time of every run, s")
      ->check(shell::between(0.1, kMaxSeconds, "seconds"))
      ->capture_default_str();
  app.add_option("--seeds", seeds_, "Average N runs, with the seeds 1, 2, ... for scenario, input and network")
      ->check(shell::range(1, 10000))
      ->capture_default_str();
  app.add_option("--netem", netem_,
                 "Impairment of datagrams, in the grammar of tc-netem; repeat for several networks;\ndefault: " + usual)
      ->type_name("SPEC")
      ->allow_extra_args(false);
  app.add_option("--input", inputs_, std::string(shell::kInputHelp) + "; repeat for more peers, in turn")
      ->type_name("SPEC")
      ->allow_extra_args(false);
  app.add_option(
         "--techniques", techniques_,
         "Some of: paper, ours, ablations, alternatives; all, which is these four; frontier, which has full at\n"
         "several budgets and further points of the alternatives' curves; or names of those below")
      ->type_name("LIST")
      ->capture_default_str();
  app.add_option("--add", added_,
                 "A further technique or alternative, with its knobs, such as 'full --lead 0.2' or\n"
                 "'rollback --input-delay 3 --hz 20'; may be repeated")
      ->type_name("TECHNIQUE")
      ->allow_extra_args(false);
  app.add_option("--jobs", jobs_, "Runs at once; default: one for each processor")->check(shell::range(1, 1024));
}

Plan PlanFlags::plan() const {
  Plan p;
  p.contestants = chosen_contestants(techniques_);
  for (const std::string& text : added_) {
    p.contestants.push_back(added_contestant(text));
    refuse_second("--add", text, p.contestants, [](const Contestant& c) { return c.id; });
  }
  for (const std::string& text : netem_.empty() ? usual_.networks : netem_) {
    std::vector<std::string> warnings;
    p.networks.push_back({text, shell::parse_netem_flag("--netem", text, &warnings)});
    // Their pictures' names do not tell spaces either.
    refuse_second("--netem", text, p.networks, [](const Network& n) { return with_single_spaces(n.text); });
    for (const std::string& w : warnings) std::cerr << "padr-lab: warning: " << w << '\n';
  }
  p.setting.scenario = scenario_;
  p.setting.peers = peers_;
  p.setting.ticks = static_cast<Tick>(std::lround(seconds_ * kTicksPerSecond));
  if (!inputs_.empty()) {
    shell::refuse_surplus_inputs(inputs_, peers_);
    p.setting.inputs = inputs_;
    shell::tell_of_paths("padr-lab", inputs_, shell::load_scenario(scenario_, 1).scene);
  }
  for (int s = 1; s <= seeds_; ++s) {
    p.seeds.push_back(static_cast<std::uint64_t>(s));
    check_setting(p.setting, p.seeds.back());  // before any file is touched, and in a dry run
  }
  p.parallel.threads = jobs_;
  return p;
}

}  // namespace padr::lab::compare
