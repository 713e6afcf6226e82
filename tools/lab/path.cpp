#include "tools/lab/path.h"

#include <cmath>
#include <cstdio>

#include "common/model/user_error.h"
#include "shell/command_line.h"
#include "shell/files.h"
#include "shell/path_csv.h"
#include "shell/path_survey.h"
#include "shell/run_main.h"

namespace padr::lab {
namespace {

constexpr double kMostSeconds = 3600;

CLI::Validator units() {
  const auto check = [](std::string& text) -> std::string {
    for (const char* known : {"px,ms", "px,s", "m,ms", "m,s"})
      if (text == known) return "";
    return "'" + text + "' is not allowed; give px,ms or px,s or m,ms or m,s";
  };
  return {check, ""};
}

float to_millimetre(float metres) {
  return std::round(metres * 1000) / 1000;
}

}  // namespace

void PathCommand::declare(CLI::App& app) {
  scenario_.declare(app);
  CLI::Option* in = app.add_option("--in", in_, "A path to convert: CSV with the columns t,x,y")->type_name("FILE");
  app.add_option(
         "--units", units_,
         "Units of --in: m or px for length, s or ms for time. Pixels are fitted to the world: scaled by the same\n"
         "factor in x and y, moved into its middle, and flipped in y, because y grows downwards on a screen")
      ->type_name("LENGTH,TIME")
      ->check(units())
      ->capture_default_str()
      ->needs(in);
  CLI::Option* stretch =
      app.add_option("--stretch", stretch_, "Multiply all times of --in by this, for paths that are too fast")
          ->type_name("FACTOR")
          ->check(shell::between(0.001, shell::kMostStretch, ""))
          ->capture_default_str()
          ->needs(in);
  CLI::Option* input = app.add_option("--input", input_, "In place of --in: made-up motion, wander[:SEED] or rest")
                           ->type_name("SPEC")
                           ->excludes(in)
                           ->excludes(stretch);
  app.add_option("--seconds", seconds_, "Length of --input, s")
      ->check(shell::between(0.1, kMostSeconds, "s"))
      ->capture_default_str()
      ->needs(input);
  app.add_option("--rate", rate_, "Points a second of --input")
      ->check(shell::range(1, kTicksPerSecond))
      ->capture_default_str()
      ->needs(input);
  app.add_option("--out", out_, "The path in seconds and metres, for --input path:FILE; - for standard output")
      ->type_name("FILE|-")
      ->required();
  app.footer(
      "Standard error gets the extent and speed of the path, and those of the scenario's world and avatars.\n"
      "\n"
      "Examples:\n"
      "  padr-lab path --in mouse.csv --units px,ms --scenario arena --out mouse-arena.csv\n"
      "  padr-lab path --input wander:7 --scenario arena --seconds 20 --out sample.csv\n"
      "Exit: 0 done, 2 usage or a file that is not a path.");
}

scenarios::Path PathCommand::converted(const Scene& scene) const {
  const bool pixels = units_.starts_with("px");
  const bool milliseconds = units_.ends_with("ms");
  shell::PathUnits units;
  if (milliseconds) units = {1000, "ms", "m", false};
  if (pixels) units.length = "px";
  units.merge = true;  // pointers are often logged several times within a millisecond
  scenarios::Path path = shell::parse_path_csv(shell::read_file("--in", in_), "--in: " + in_, units);
  if (pixels) path = shell::fit_path(path, "--in: " + in_, scene, true);
  std::vector<scenarios::PathPoint> points = path.points();
  const double begin = points.front().seconds;
  for (scenarios::PathPoint& p : points) p.seconds = std::round((p.seconds - begin) * stretch_ * 1e6) / 1e6;
  return scenarios::Path(std::move(points));
}

scenarios::Path PathCommand::made(const Scene& scene) const {
  if (input_.starts_with("path:")) throw UserError("--input: '" + input_ + "' is a path already; give it with --in");
  const auto source = shell::load_input(input_, scene, 0, scenario_.seed());
  std::vector<scenarios::PathPoint> points;
  const auto last = static_cast<int>(std::floor(seconds_ * rate_));
  for (int i = 0; i <= last; ++i) {
    const double seconds = static_cast<double>(i) / rate_;
    const Vec2 at = source->target(static_cast<Tick>(std::lround(seconds * kTicksPerSecond)));
    points.push_back({std::round(seconds * 1e6) / 1e6, {to_millimetre(at.x), to_millimetre(at.y)}});
  }
  if (points.size() < 2) throw UserError("--seconds: too short for two points at --rate " + std::to_string(rate_));
  return scenarios::Path(std::move(points));
}

int PathCommand::run(const std::vector<std::string>& command) const {
  if (in_.empty() == input_.empty()) throw UserError("path: give one of --in and --input");
  const shell::LoadedScenario scenario = scenario_.load();
  const scenarios::Path path = in_.empty() ? made(scenario.scene) : converted(scenario.scene);
  std::vector<std::string> recipe = command;
  recipe.front() = "padr-lab";  // wherever that is
  const std::string text = "# " + shell::shell_line(recipe) + "\n" + shell::write_path_csv(path);
  shell::write_text("--out", out_, text);
  const shell::PathNotes notes = shell::notes_on_path(path, out_, scenario.scene);
  std::fprintf(stderr, "padr-lab: %s\n", notes.summary.c_str());
  for (const std::string& w : notes.warnings) std::fprintf(stderr, "padr-lab: warning: %s\n", w.c_str());
  return shell::kExitFine;
}

}  // namespace padr::lab
