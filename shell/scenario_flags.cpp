#include "shell/scenario_flags.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "common/model/user_error.h"
#include "common/scenarios/scenarios.h"
#include "shell/command_line.h"
#include "shell/files.h"
#include "shell/input_text.h"
#include "shell/path_csv.h"
#include "shell/text.h"

namespace padr::shell {
namespace {

std::string names() {
  std::string all;
  for (const std::string_view n : scenarios::embedded_names()) all += (all.empty() ? "" : ", ") + std::string(n);
  return all;
}

}  // namespace

void ScenarioFlags::declare(CLI::App& app) {
  const std::string group = "World";
  app.add_option("--scenario", scenario_, "Built in: " + names() + "; or a file of your own")
      ->type_name("NAME|FILE")
      ->capture_default_str()
      ->group(group);
  app.add_option("--seed", seed_, "Seed of the scenario, and of generated input without a seed of its own")
      ->type_name("N")
      ->check(whole_number())
      ->capture_default_str()
      ->group(group);
}

LoadedScenario ScenarioFlags::load() const {
  return load_scenario(scenario_, seed_);
}

LoadedScenario load_scenario(const std::string& name, std::uint64_t seed) {
  LoadedScenario s;
  s.label = name;
  s.seed = seed;
  const auto known = scenarios::embedded_names();
  if (std::find(known.begin(), known.end(), name) != known.end()) {
    s.text = std::string(scenarios::embedded_text(name));
    s.scene = scenarios::load_embedded(name, seed);
    return s;
  }
  std::error_code error;
  if (!std::filesystem::exists(name, error))
    throw UserError("--scenario: '" + name + "' is neither a file nor one of " + names());
  s.text = read_file("--scenario", name);
  s.scene = scenarios::load(s.text, name, seed);
  for (const auto& [field, text] : {std::pair{"name", &s.scene.name}, std::pair{"title", &s.scene.title}})
    if (valid_utf8(*text) != *text) throw UserError(name + ": " + field + " is not well-formed, allowed: UTF-8");
  return s;
}

std::unique_ptr<scenarios::InputSource> load_input(std::string_view spec, const Scene& scene, int slot,
                                                   std::uint64_t seed) {
  const InputContext context{scene, slot, seed, [](const std::string& file) { return read_file("--input", file); }};
  try {
    return make_input(spec, context);
  } catch (const UserError& e) {
    std::string line = e.what();
    if (!line.starts_with("--input")) line = "--" + std::string(line.starts_with("input:") ? "" : "input: ") + line;
    throw UserError(line);
  }
}

void refuse_surplus_inputs(const std::vector<std::string>& specs, int peers) {
  if (std::ssize(specs) > peers)
    throw UserError("--input: given " + std::to_string(specs.size()) + " times, but --peers is " +
                    std::to_string(peers));
}

std::optional<PathNotes> notes_on_input(std::string_view spec, const Scene& scene) {
  const auto path = path_text(spec);
  if (!path) return std::nullopt;
  return notes_on_path(parse_path_csv(read_file("--input", path->file), "--input: " + path->file), path->file, scene);
}

void tell_of_paths(const char* program, const std::vector<std::string>& specs, const Scene& scene) {
  for (auto spec = specs.begin(); spec != specs.end(); ++spec) {
    if (std::find(specs.begin(), spec, *spec) != spec) continue;
    const auto notes = notes_on_input(*spec, scene);
    if (!notes) continue;
    std::fprintf(stderr, "%s: %s\n", program, notes->summary.c_str());
    for (const std::string& w : notes->warnings) std::fprintf(stderr, "%s: warning: %s\n", program, w.c_str());
  }
}

}  // namespace padr::shell
