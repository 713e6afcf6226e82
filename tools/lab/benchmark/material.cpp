#include "tools/lab/benchmark/material.h"

#include <algorithm>
#include <cctype>
#include <string_view>

#include "shell/path_csv.h"
#include "shell/scenario_flags.h"
#include "tools/plot/gnuplot.h"

namespace padr::lab::benchmark {
namespace {

std::string path_of(scenarios::InputSource& input, Tick ticks) {
  std::vector<scenarios::PathPoint> points;
  for (Tick t = 0; t <= ticks; ++t) points.push_back({static_cast<double>(t) / kTicksPerSecond, input.target(t)});
  return shell::write_path_csv(scenarios::Path(std::move(points)));
}

std::string file_name_of(const std::string& trace) {
  std::string name;
  for (const char c : trace.substr(trace.rfind('/') + 1))
    name += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.' ? c : '_';
  return name.ends_with(".link") ? name : name + ".link";
}

/// That name, or with a number if another text has it.
std::string free_name(const std::string& name, const std::string& text, const std::vector<plot::NamedText>& taken) {
  const std::string stem = name.substr(0, name.size() - std::string_view(".link").size());
  std::string free = name;
  const auto is_taken = [&](const plot::NamedText& t) { return t.name == free && t.text != text; };
  for (int n = 2; std::any_of(taken.begin(), taken.end(), is_taken); ++n)
    free = stem + "-" + std::to_string(n) + ".link";
  return free;
}

}  // namespace

void write_material(const compare::Plan& plan, const std::string& dir) {
  const compare::Setting& s = plan.setting;
  std::vector<plot::NamedText> inputs;
  for (const std::uint64_t seed : plan.seeds) {
    const Scene scene = shell::load_scenario(s.scenario, seed).scene;
    for (int p = 0; p < s.peers; ++p) {
      const std::string& spec = s.inputs[static_cast<std::size_t>(p) % s.inputs.size()];
      const auto input = shell::load_input(spec, scene, p, seed);
      inputs.push_back({"seed" + std::to_string(seed) + "-peer" + std::to_string(p) + ".csv",
                        "# " + spec + ", seed " + std::to_string(seed) + ", peer " + std::to_string(p) + ", scenario " +
                            s.scenario + "\n" + path_of(*input, s.ticks)});
    }
  }
  plot::write_into("--out", dir + "/inputs", inputs);
  std::vector<plot::NamedText> links;
  for (const compare::Network& n : plan.networks) {
    const auto& trace = n.spec.trace;
    if (!trace.opportunities) continue;
    std::string text;
    for (const std::uint32_t ms : *trace.opportunities) text += std::to_string(ms) + "\n";
    links.push_back({free_name(file_name_of(trace.name), text, links), std::move(text)});
  }
  if (!links.empty()) plot::write_into("--out", dir + "/links", links);
}

}  // namespace padr::lab::benchmark
