#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/model/scene.h"
#include "common/scenarios/input.h"
#include "shell/path_survey.h"

namespace padr::shell {

/// Avatar slots by default, if the scenario has room for more. Every slot costs each peer something, also an empty one.
inline constexpr int kUsualSlots = 32;

/// A scenario with where it came from.
struct LoadedScenario {
  Scene scene;
  std::string label;  ///< as the flag was written
  std::string text;
  std::uint64_t seed = 0;
};

/// The built-in scenario of that name, else the file; messages name the flag --scenario. Throws UserError.
LoadedScenario load_scenario(const std::string& name, std::uint64_t seed);

/// --scenario NAME|FILE and --seed N.
class ScenarioFlags {
 public:
  void declare(CLI::App& app);
  /// After parsing: a built-in scenario of that name, else a file. Throws UserError.
  LoadedScenario load() const;
  std::uint64_t seed() const { return seed_; }

 private:
  std::string scenario_ = "arena";
  std::uint64_t seed_ = 1;
};

/// `path:`, `wander` or `rest`, as make_input has it, with files read from disk; `seed` is for input that
/// names none. Throws UserError that starts with --input.
std::unique_ptr<scenarios::InputSource> load_input(std::string_view spec, const Scene& scene, int slot,
                                                   std::uint64_t seed);

/// Throws UserError that names --input if there are more of them than peers: some would not be read.
void refuse_surplus_inputs(const std::vector<std::string>& specs, int peers);

/// What to tell the user of the path that `spec` names; nothing if it names none. Throws UserError as load_input does.
std::optional<PathNotes> notes_on_input(std::string_view spec, const Scene& scene);
/// The same of each of several, on standard error, each once. `program` begins every line.
void tell_of_paths(const char* program, const std::vector<std::string>& specs, const Scene& scene);

/// What --input can be, for help texts.
inline constexpr const char* kInputHelp =
    "path:FILE[,loop] (CSV of t,x,y in s and m), wander[:SEED] (made-up human motion) or rest";

}  // namespace padr::shell
