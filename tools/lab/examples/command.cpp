#include "tools/lab/examples/command.h"

#include <algorithm>
#include <iostream>
#include <sstream>

#include "common/model/user_error.h"
#include "shell/command_line.h"
#include "shell/files.h"
#include "shell/path_csv.h"
#include "shell/run_main.h"
#include "tools/lab/examples/film.h"
#include "tools/lab/examples/results.h"
#include "tools/plot/svg.h"

namespace padr::lab {
namespace {

using namespace examples;

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> words;
  std::istringstream in(list);
  for (std::string word; std::getline(in, word, ',');) words.push_back(word);
  return words;
}

/// Draws the films and the series of dominoes into `dir`.
plot::Drawing draw_pictures(const std::string& dir, const Plan& plan, const Results& results) {
  const std::vector<std::pair<std::string, Technique>> shown{
      {"without authority (avatar-only)", without_authority().technique},
      {"with authority (the paper's adaptive)", technique_by_name("adaptive")}};
  std::vector<std::string> films;
  for (const std::string& name : plan.stories) {
    const plot::FilmStrip film = film_of(story_by_name(name), shown, plan.netem);
    plot::write_into("--out", dir, {plot::film_svg(film)});
    films.push_back(film.name);
  }
  std::string wrong = plot::rasterize(dir, films);
  if (results.rows.empty()) return {wrong};
  const plot::LinePlot series = dominoes_plot(results);
  plot::write_into("--out", dir, plot::files(series));
  const plot::Drawing also = plot::draw(dir, {series.name});
  return {wrong.empty() ? also.wrong : wrong, also.failed};
}

}  // namespace

void ExamplesCommand::declare(CLI::App& app) {
  app.add_option("--out", out_, "Folder for tables, films and plots")->type_name("DIR")->required();
  app.add_option("--stories", stories_,
                 "Stories to play, with commas between them; in a story with -missed the avatar\n"
                 "touches the body and its model misses it")
      ->type_name("LIST")
      ->capture_default_str();
  app.add_option("--takes", takes_,
                 "Play each story along N slightly different paths and average; the film shows the first")
      ->check(shell::range(1, 1000))
      ->capture_default_str();
  app.add_option("--netem", netem_,
                 "Impairment of datagrams, in the grammar of tc-netem; default: none, so that only\n"
                 "model errors count")
      ->type_name("SPEC");
  app.add_option("--jobs", jobs_, "Runs at once; default: one for each processor")->check(shell::range(1, 1024));
  app.add_option("--json", json_, "Write the summary to a file, or - for standard output in place of the table")
      ->type_name("FILE|-");
  app.add_flag("--no-pictures", no_pictures_, "Tables only");
  app.footer(
      "In ball and dominoes, as in the paper, and in van and carton the avatar of peer 0 stops just short of a body, "
      "and its\n"
      "model at peer 1 runs on into the body. In proxy and in the stories with -missed the avatar does touch a body; "
      "in\n"
      "the latter the model misses it. The error of the bodies is the physics-consistency cost. Written to DIR:\n"
      "examples.csv (means), takes.csv (every run), predictors.csv (the cost that each predictor avoided),\n"
      "summary.json, path-STORY.csv (the avatar's path on film, for --input path:FILE), film-STORY.svg and .png (the\n"
      "views of both peers), dominoes.* (cost by number of dominoes). The same flags write the same files.\n"
      "Example:\n"
      "  padr-lab examples --out out/examples\n"
      "  padr-lab examples --out out/late --stories proxy --netem \"delay 100ms\" --takes 32\n"
      "Exit: 0 done, 1 gnuplot failed, 2 usage.");
}

int ExamplesCommand::run(const std::vector<std::string>& command) {
  Plan plan;
  plan.stories = split(stories_);
  if (plan.stories.empty()) throw UserError("--stories: '' is not allowed; give some of ball, dominoes, van, ...");
  for (const std::string& s : plan.stories) {
    story_by_name(s);
    if (std::count(plan.stories.begin(), plan.stories.end(), s) > 1)
      throw UserError("--stories: '" + s + "' is there twice; give every one once");
  }
  plan.takes = takes_;
  std::vector<std::string> warnings;
  plan.netem = shell::parse_netem_flag("--netem", netem_, &warnings);
  plan.netem_text = netem_;
  plan.parallel.threads = jobs_;
  for (const std::string& w : warnings) std::cerr << "padr-lab: warning: " << w << '\n';
  plot::write_into("--out", out_, {});
  shell::check_writable("--json", json_);

  const Results results = run_plan(plan);
  const std::string summary = examples::json(results, plan, shell::shell_line(command));
  plot::write_into("--out", out_,
                   {{"examples.csv", csv(results)},
                    {"takes.csv", takes_csv(results)},
                    {"predictors.csv", verdicts_csv(results)},
                    {"summary.json", summary}});
  for (const std::string& name : plan.stories)
    plot::write_into("--out", out_,
                     {{"path-" + name + ".csv", shell::write_path_csv(path_of(story_by_name(name), 0))}});
  if (json_ != "-") std::cout << table(results, plan);
  if (!json_.empty()) shell::write_text("--json", json_, summary);
  if (no_pictures_) return shell::kExitFine;
  const plot::Drawing drawing = draw_pictures(out_, plan, results);
  if (!drawing.wrong.empty()) std::cerr << "padr-lab: " << drawing.wrong << '\n';
  return drawing.failed ? shell::kExitFailure : shell::kExitFine;
}

}  // namespace padr::lab
