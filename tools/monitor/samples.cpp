#include "tools/monitor/samples.h"

#include <memory>
#include <utility>
#include <vector>

#include "common/model/user_error.h"
#include "common/scenarios/embedded.h"
#include "shell/input_text.h"
#include "shell/netem_flags.h"
#include "shell/revision.h"
#include "shell/scenario_flags.h"
#include "shell/technique_text.h"
#include "tools/lab/simulation.h"

namespace padr::monitor {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr const char* kPathFolder = "common/scenarios/paths/";
constexpr const char* kBadNetwork = "delay 100ms 50ms loss 10%";
constexpr const char* kFarAway = "delay 200ms 40ms loss 5%";

constexpr std::array<Sample, 7> kSamples{{
    {"stop-short",
     "Stopping short",
     "Avatar 0 stops just short of a ball. Nobody has authority here, so in the picture of peer 1 the avatar's model "
     "runs on and pushes the ball, which nobody has touched. Both peers show nearly the same distance off: without "
     "authority no view is the right one, so the distance is the one between the two views. The confirmed worlds are "
     "identical all the same: they are made of what the peers told each other, and nobody has told of the ball.",
     "tools/demo.sh --scene stop-short",
     "ball",
     "avatar-only --threshold 0.8",
     {"path:common/scenarios/paths/ball.csv", "rest"},
     "",
     2,
     10},
    {"predictor",
     "A predictor warns in time",
     "Avatar 0 stops just short of a row of dominoes. A predictor sees that its model would hit them, and the "
     "threshold "
     "falls from 0.8 m to 0.3 m: the model is put right before it gets there.",
     "tools/demo.sh --scene predictor",
     "dominoes",
     "avatar-only --threshold 0.8:0.3 --predictor pcc",
     {"path:common/scenarios/paths/dominoes.csv", "rest"},
     "",
     2,
     10},
    {"proxy",
     "Collision by proxy",
     "Avatar 0 pushes one thing into another and that into a third. The owner of the avatar decides about all "
     "three, and sends their exact states when the chain breaks.",
     "tools/demo.sh --scene proxy",
     "proxy",
     "adaptive",
     {"path:common/scenarios/paths/proxy.csv", "rest"},
     "",
     2,
     10},
    {"bad-network-fixed",
     "A bad network, by fixed",
     "Four players push things about, 100 ms ± 50 ms apart, and 10 % of what they send is lost. Updates are applied "
     "when "
     "they arrive: things end up in different places, and stay there.",
     "tools/demo.sh --technique fixed",
     "arena",
     "fixed",
     {"wander", ""},
     kBadNetwork,
     4,
     20},
    {"bad-network-full",
     "The same bad network, by full",
     "The same players and the same network. Late updates are put where they belong, in the past, and everything since "
     "is "
     "played again: the pictures are the same but for avatars that have just turned.",
     "tools/demo.sh",
     "arena",
     "full",
     {"wander", ""},
     kBadNetwork,
     4,
     20},
    {"shown-pvb",
     "Corrections by pvb",
     "Four players who are 200 ms apart. What others do has to be corrected all the time; the pictures follow by "
     "projective velocity blending.",
     "tools/demo.sh",
     "arena",
     "full --convergence pvb",
     {"wander", ""},
     kFarAway,
     4,
     20},
    {"shown-track",
     "Corrections by track",
     "The same players, the same datagrams. The pictures follow as fast as steps may change.",
     "tools/demo.sh",
     "arena",
     "full --convergence track",
     {"wander", ""},
     kFarAway,
     4,
     20},
}};

std::string_view input_of(const Sample& s, int peer) {
  return s.inputs[s.inputs[1].empty() ? 0 : static_cast<std::size_t>(peer) % 2];
}

std::string built_in_path(const std::string& file) {
  for (const scenarios::Embedded& p : scenarios::embedded_paths())
    if (file == kPathFolder + std::string(p.name) + ".csv") return std::string(p.text);
  throw UserError("there is no built-in path '" + file + "'");
}

}  // namespace

std::span<const Sample> samples() {
  return kSamples;
}

const Sample* find_sample(std::string_view name) {
  for (const Sample& s : kSamples)
    if (s.name == name) return &s;
  return nullptr;
}

std::string lab_command(const Sample& s) {
  std::string text = "padr-lab run --scenario " + std::string(s.scenario) + " --peers " + std::to_string(s.peers) +
                     " --technique " + std::string(s.technique);
  for (const std::string_view input : s.inputs)
    if (!input.empty()) text += " --input " + std::string(input);
  if (!s.netem.empty()) text += " --netem \"" + std::string(s.netem) + "\"";
  return text + " --seconds " + std::to_string(s.seconds) + " --seed " + std::to_string(kSeed);
}

Film film_sample(const Sample& s) {
  const shell::LoadedScenario scenario = shell::load_scenario(std::string(s.scenario), kSeed);
  lab::SimulationConfig config;
  config.scene = scenario.scene;
  config.peers = s.peers;
  config.technique = shell::technique_of(s.technique);
  config.netem = shell::parse_netem_flag("--netem", s.netem, nullptr);
  config.netem_seed = kSeed;
  config.ticks = s.seconds * kTicksPerSecond;
  std::vector<std::unique_ptr<scenarios::InputSource>> inputs;
  std::vector<NamedTrace> traces(static_cast<std::size_t>(s.peers));
  for (int p = 0; p < s.peers; ++p) {
    inputs.push_back(shell::make_input(input_of(s, p), {scenario.scene, p, kSeed, built_in_path}));
    config.inputs.push_back(inputs.back().get());
    NamedTrace& trace = traces[static_cast<std::size_t>(p)];
    trace.name = "peer " + std::to_string(p) + " of sample " + std::string(s.name);
    node::RecordedReplica::Recording r;
    r.provenance.program = "padr-lab";
    r.provenance.revision = std::string(shell::revision());
    r.provenance.command = {lab_command(s)};
    r.provenance.scenario = scenario.label;
    r.provenance.scenario_text = scenario.text;
    r.provenance.scenario_seed = scenario.seed;
    r.provenance.netem = s.netem;
    r.provenance.netem_seed = kSeed;
    r.provenance.input = input_of(s, p);
    r.sink = [&trace](std::span<const std::byte> bytes) {
      trace.bytes.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    };
    config.recordings.emplace_back(std::move(r));
  }
  lab::Simulation simulation(std::move(config));
  simulation.run();
  simulation.finish();
  return film_traces(std::move(traces), [](const std::string&) {});
}

}  // namespace padr::monitor
