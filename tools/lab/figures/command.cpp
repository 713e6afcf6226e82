#include "tools/lab/figures/command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "common/model/user_error.h"
#include "shell/command_line.h"
#include "shell/input_text.h"
#include "shell/run_main.h"
#include "shell/technique_text.h"
#include "tools/lab/figures/html.h"
#include "tools/lab/figures/pictures.h"
#include "tools/lab/figures/results_text.h"
#include "tools/lab/figures/words.h"
#include "tools/lab/unmeasured.h"

namespace padr::lab {
namespace {

using namespace figures;

constexpr double kLeastSeconds = 3;  // a third of it is a second
constexpr double kMostSeconds = 3600;
constexpr std::size_t kMostCases = 200;

/// "path:somewhere/user 7.csv,loop" gives "user-7".
std::string short_name(const std::string& input) {
  const auto path = shell::path_text(input);
  std::string name = path ? std::filesystem::path(path->file).stem().string() : input;
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '-';
  return name;
}

std::string kind_of(const std::string& input) {
  return input.starts_with("path:") ? "recorded" : short_name(input);
}

/// These tell the settings from one another.
bool is_the_settings_own(std::string_view flag) {
  return flag == "--threshold" || flag == "--predictor";
}

/// Of each setting, the mean of its cases.
void warn_of_each(const Plan& p, const Results& results) {
  for (std::size_t s = 0; s < p.settings.size(); ++s) {
    std::vector<double> shares;
    for (const std::vector<FigureRun>& of_case : results.runs)
      shares.push_back(static_cast<double>(of_case[s].watched.size()) / p.ticks);
    warn_of_unmeasured(p.settings[s].title, mean_of(shares), p.ticks);
  }
}

/// A name that no other case has.
void add_case(std::vector<Case>& cases, Case c) {
  const std::string base = c.id;
  const auto taken = [&cases](const std::string& id) {
    return std::any_of(cases.begin(), cases.end(), [&id](const Case& other) { return other.id == id; });
  };
  for (int n = 2; taken(c.id); ++n) c.id = base + "-" + std::to_string(n);
  cases.push_back(std::move(c));
}

}  // namespace

void FiguresCommand::declare(CLI::App& app) {
  app.add_option("--out", out_, "Folder for data, pictures and report.html")->type_name("DIR")->required();
  scenario_.declare(app);
  app.add_option("--seeds", seeds_, "Number of seeds, from --seed on; every input is played with each seed")
      ->check(shell::range(1, 100))
      ->capture_default_str();
  app.add_option("--input", inputs_,
                 std::string("What drives the avatar: ") + shell::kInputHelp +
                     ";\nrepeat for several inputs; default: wander, a different one for each seed")
      ->type_name("SPEC");
  app.add_option("--seconds", seconds_, "Virtual length of a run, s")
      ->check(shell::between(kLeastSeconds, kMostSeconds, "seconds"))
      ->capture_default_str();
  app.add_option("--netem", netem_,
                 "Impairment of datagrams, in the grammar of tc-netem; default: none, so that an update\n"
                 "takes one tick; the paper has no latency")
      ->type_name("SPEC");
  knobs_.resize(shell::knobs().size());
  for (std::size_t k = 0; k < knobs_.size(); ++k) {
    const shell::Knob& knob = shell::knobs()[k];
    if (is_the_settings_own(knob.flag)) continue;
    app.add_option(knob.flag, knobs_[k], knob.help)->type_name(knob.type)->group("Technique (of every setting)");
  }
  app.add_option("--add", added_, "A further setting, with its knobs, such as 'full --lead 0.2'; may be repeated")
      ->type_name("TECHNIQUE")
      ->allow_extra_args(false);
  app.add_option("--jobs", jobs_, "Runs at once; default: one for each processor")->check(shell::range(1, 1024));
  app.add_flag("--no-pictures", no_pictures_, "Write data only; report.html then has no pictures");
  app.footer(
      "The paper's experiments: of two peers one has a driven avatar, and the other one's avatar rests. The view of "
      "the\n"
      "resting one is compared with the truth. Each case (input and seed) runs with each technique: avatar-only, "
      "fixed\n"
      "thresholds of 0.8, 0.5 and 0.3 m, the adaptive threshold 0.8:0.3 m with each predictor, and full.\n"
      "Written to DIR:\n"
      "  report.html                 everything on one page that needs no other file\n"
      "  figure6-CASE .. figure9-CASE, drift, peaks, prediction   each as .svg, .png, .csv and .gp\n"
      "  summary.json, runs.csv, predictors.csv, series-CASE.csv  the measurements\n"
      "The same flags write the same data, to the byte.\n"
      "Example:\n"
      "  padr-lab figures --out out/figures\n"
      "  padr-lab figures --out out/agreed --unowned agreed --add 'full --lead 0.2'\n"
      "  padr-lab figures --out out/mine --input path:mouse.csv,loop --input wander --seeds 2 --seconds 120\n"
      "Exit: 0 done (also if a claim does not hold), 1 the pictures could not be drawn, 2 usage.");
}

std::string FiguresCommand::canonical() const {
  std::vector<std::string> words{"padr-lab",   "figures",
                                 "--scenario", scenario_.load().label,
                                 "--seed",     std::to_string(scenario_.seed()),
                                 "--seeds",    std::to_string(seeds_),
                                 "--seconds",  plot::number(seconds_)};
  for (const std::string& input : inputs_) words.insert(words.end(), {"--input", input});
  if (!netem_.empty()) words.insert(words.end(), {"--netem", netem_});
  for (std::size_t k = 0; k < knobs_.size(); ++k)
    if (!knobs_[k].empty()) words.insert(words.end(), {shell::knobs()[k].flag, knobs_[k]});
  for (const std::string& text : added_) words.insert(words.end(), {"--add", text});
  return shell::shell_line(words);
}

std::vector<Setting> FiguresCommand::settings() const {
  std::vector<Setting> all = figure_settings();
  for (Setting& s : all)
    for (std::size_t k = 0; k < knobs_.size(); ++k)
      if (!knobs_[k].empty()) shell::knobs()[k].set(s.technique, knobs_[k]);
  for (const std::string& text : added_) {
    std::string id = text;
    for (char& c : id)
      if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.') c = '-';
    const bool taken = std::any_of(all.begin(), all.end(), [&id](const Setting& s) { return s.id == id; });
    const Technique t = shell::technique_of(text);
    if (taken) throw UserError("--add: '" + text + "' is there already");
    all.push_back({id, text, t});
  }
  return all;
}

figures::Plan FiguresCommand::plan() const {
  Plan p;
  std::vector<std::string> warnings;
  p.netem = shell::parse_netem_flag("--netem", netem_, &warnings);
  for (const std::string& w : warnings) std::cerr << "padr-lab: warning: " << w << '\n';
  p.netem_text = netem_;
  p.settings = settings();
  p.ticks = static_cast<Tick>(std::lround(seconds_ * kTicksPerSecond));
  p.scenario = scenario_.load().label;
  p.command = canonical();
  const std::vector<std::string> inputs = inputs_.empty() ? std::vector<std::string>{"wander"} : inputs_;
  if (inputs.size() * static_cast<std::size_t>(seeds_) > kMostCases)
    throw UserError("--seeds: " + std::to_string(seeds_) + " times " + std::to_string(inputs.size()) +
                    " inputs is more than " + std::to_string(kMostCases) + " cases");
  if (!inputs.empty()) shell::tell_of_paths("padr-lab", inputs, scenario_.load().scene);
  for (const std::string& input : inputs) {
    for (int i = 0; i < seeds_; ++i) {
      const std::uint64_t seed = scenario_.seed() + static_cast<std::uint64_t>(i);
      Scene scene = shell::load_scenario(p.scenario, seed).scene;
      if (scene.avatar.spawns.size() < 2)
        throw UserError("--scenario: " + p.scenario + " has room for one peer; two are needed");
      const std::string name = short_name(input);
      add_case(p.cases, {name + "-" + std::to_string(seed), name + ", seed " + std::to_string(seed), kind_of(input),
                         input, seed, std::move(scene)});
      // Mistakes in files show before hours are spent.
      shell::load_input(input, p.cases.back().scene, 0, seed);
    }
  }
  return p;
}

int FiguresCommand::run() {
  const Plan p = plan();
  plot::write_into("--out", out_, {});
  const auto start = std::chrono::steady_clock::now();
  const ParallelOptions parallel{.threads = jobs_};
  const Results results = run_plan(p, parallel);
  const double spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  warn_of_each(p, results);
  const std::vector<Claim> claims = judge_claims(p, results);
  plot::write_into("--out", out_, csv_files(p, results));
  plot::write_into("--out", out_, {{"summary.json", json(p, results, claims)}});
  std::cout << table(p, results, claims);

  std::string wrong;
  if (!no_pictures_) wrong = draw_pictures(out_, p, results, parallel);
  plot::write_into("--out", out_, {{"report.html", html(out_, p, results, claims, !no_pictures_ && wrong.empty())}});
  std::cout << "\n"
            << p.cases.size() * p.settings.size() << " runs in " << fixed(spent, 1) << " s; see "
            << (std::filesystem::path(out_) / "report.html").string() << "\n";
  if (wrong.empty()) return shell::kExitFine;
  std::cerr << "padr-lab: " << wrong << '\n';
  return shell::kExitFailure;
}

}  // namespace padr::lab
