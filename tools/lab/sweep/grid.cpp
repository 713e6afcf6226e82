#include "tools/lab/sweep/grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/model/hash.h"
#include "common/model/ids.h"
#include "common/model/user_error.h"
#include "common/scenarios/bodies.h"
#include "common/scenarios/scenarios.h"
#include "common/world/fingerprint.h"
#include "shell/files.h"
#include "shell/input_text.h"
#include "shell/netem_flags.h"
#include "shell/revision.h"
#include "shell/scenario_flags.h"
#include "shell/technique_text.h"
#include "tools/lab/sweep/values.h"

namespace padr::lab::sweep {
namespace {

constexpr std::uint64_t kMostBodies = 5000;  // what scenarios may have
constexpr std::size_t kMostRuns = 10'000'000;

std::vector<double> times(std::string_view flag, const std::string& text) {
  return text.empty() ? std::vector<double>{0} : milliseconds_of(flag, text);
}

std::string column_of(std::string_view flag) {
  std::string name(flag.substr(2));
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

std::string netem_text(double delay_ms, double jitter_ms, double loss_percent, const std::string& more) {
  std::string s;
  if (delay_ms > 0 || jitter_ms > 0) s += "delay " + plain(delay_ms) + "ms " + plain(jitter_ms) + "ms ";
  if (loss_percent > 0) s += "loss " + plain(loss_percent) + "% ";
  return s + more;
}

double milliseconds(link::Nanos t) {
  return static_cast<double>(t) / static_cast<double>(link::kNanosPerMilli);
}

bool sets(const std::string& technique, std::string_view flag) {
  const std::string words = " " + technique + " ";
  for (const char end : {' ', '='})
    if (words.find(" " + std::string(flag) + end) != std::string::npos) return true;
  return false;
}

}  // namespace

Grid::Grid(const GridText& t)
    : scenarios_(words_of("--scenario", t.scenarios)),
      peers_(integers_of("--peers", t.peers, 1, kMaxPeers)),
      delay_ms_(times("--delay", t.delay)),
      jitter_ms_(times("--jitter", t.jitter)),
      loss_percent_(t.loss.empty() ? std::vector<double>{0} : percents_of("--loss", t.loss)),
      netem_(t.netem),
      techniques_(words_of("--technique", t.techniques)),
      seeds_(integers_of("--seeds", t.seeds, 0, std::numeric_limits<std::uint64_t>::max())),
      seconds_(t.seconds),
      settle_seconds_(t.settle_seconds),
      inputs_(t.inputs.empty() ? std::vector<std::string>{"wander"} : t.inputs) {
  const auto fewest = static_cast<int>(*std::min_element(peers_.begin(), peers_.end()));
  if (t.watch && (*t.watch < 0 || *t.watch >= fewest))
    throw UserError("--watch: '" + std::to_string(*t.watch) + "' is not allowed; give 0 to " +
                    std::to_string(fewest - 1));
  if (t.watch) watched_ = static_cast<PeerId>(*t.watch);
  bodies_ = {std::nullopt};
  if (!t.bodies.empty()) {
    bodies_.clear();
    for (const std::uint64_t n : integers_of("--bodies", t.bodies, 1, kMostBodies))
      bodies_.emplace_back(static_cast<std::uint32_t>(n));
  }
  for (std::size_t k = 0; k < t.knobs.size(); ++k) {
    if (t.knobs[k].empty()) continue;
    knobs_.push_back(k);
    knob_columns_.push_back(column_of(shell::knobs()[k].flag));
    knob_values_.push_back(words_of(shell::knobs()[k].flag, t.knobs[k]));
  }
  std::vector<std::size_t> lengths{scenarios_.size(), bodies_.size(),       peers_.size(),      delay_ms_.size(),
                                   jitter_ms_.size(), loss_percent_.size(), techniques_.size(), seeds_.size()};
  for (const auto& values : knob_values_) lengths.push_back(values.size());
  size_ = 1;
  for (const std::size_t n : lengths) {
    if (size_ > kMostRuns / n) throw UserError("the grid has more than 10 million runs: give shorter lists");
    size_ *= n;
  }
  check_techniques();
  look_into_netem(t);
  check_sessions();
  note_given(t);
  id_ = identify();
}

// Rows would be named by the lists and played by --netem. Of two delays the last one counts: one that stays whatever
// stands before it is --netem's own.
void Grid::look_into_netem(const GridText& t) {
  const auto after = [this](const std::string& before) {
    return shell::parse_netem_flag("--netem", before + netem_, nullptr);
  };
  const link::NetemSpec one = after("delay 1ms 1ms ");
  netem_has_delay_ = one.delay == after("delay 2ms 1ms ").delay;
  netem_has_loss_ = one.loss != link::NetemSpec{}.loss;
  const auto refuse = [&t](bool has, const std::string& list, const char* what, const char* flag) {
    if (has && !list.empty())
      throw UserError("--netem: '" + t.netem + "' has a " + what + ", and so has " + flag + "; give it in one of them");
  };
  refuse(netem_has_delay_, t.delay, "delay", "--delay");
  refuse(netem_has_delay_, t.jitter, "delay", "--jitter");
  refuse(netem_has_loss_, t.loss, "loss", "--loss");
}

void Grid::take_from_netem(Point& p) const {
  if (netem_has_delay_) {
    p.delay_ms = milliseconds(p.netem.delay.mean);
    p.jitter_ms = milliseconds(p.netem.delay.jitter);
  }
  if (!netem_has_loss_) return;
  p.loss_percent.reset();
  constexpr double kDigits = 1e6;  // a chance is a 32-bit number, and no whole per cent
  if (const auto* random = std::get_if<link::Knob>(&p.netem.loss))
    p.loss_percent = std::round(100 * kDigits * random->chance / link::kAlways) / kDigits;
}

void Grid::note_given(const GridText& t) {
  if (!t.netem.empty()) given_.emplace_back("netem", t.netem);
  std::string inputs;
  for (const std::string& input : t.inputs) inputs += (inputs.empty() ? "" : " ") + input;
  if (!inputs.empty()) given_.emplace_back("input", inputs);
  if (t.watch) given_.emplace_back("watched_peer", std::to_string(*t.watch));
  if (t.settle_seconds > 0) given_.emplace_back("settle_s", plain(t.settle_seconds));
}

Point Grid::point(std::size_t index) const {
  const auto pick = [&index](const auto& values) {
    const auto& v = values[index % values.size()];
    index /= values.size();
    return v;
  };
  Point p;
  p.seed = pick(seeds_);
  p.knobs.resize(knobs_.size());
  for (std::size_t k = knobs_.size(); k-- > 0;) p.knobs[k] = pick(knob_values_[k]);
  p.technique_name = pick(techniques_);
  const double loss_percent = pick(loss_percent_);
  p.loss_percent = loss_percent;
  p.jitter_ms = pick(jitter_ms_);
  p.delay_ms = pick(delay_ms_);
  p.peers = static_cast<int>(pick(peers_));
  p.bodies = pick(bodies_);
  p.scenario = pick(scenarios_);
  p.technique = shell::technique_of(p.technique_name);
  for (std::size_t k = 0; k < knobs_.size(); ++k) shell::knobs()[knobs_[k]].set(p.technique, p.knobs[k]);
  p.netem = shell::parse_netem_flag("--netem", netem_text(p.delay_ms, p.jitter_ms, loss_percent, netem_), nullptr);
  take_from_netem(p);
  return p;
}

void Grid::check_techniques() {
  for (const std::string& name : techniques_) {
    Technique t = shell::technique_of(name);
    for (std::size_t k = 0; k < knobs_.size(); ++k) {
      const shell::Knob& knob = shell::knobs()[knobs_[k]];
      if (sets(name, knob.flag))
        throw UserError(std::string(knob.flag) + ": '" + name +
                        "' of --technique sets it, too; give it in one of them");
      for (const std::string& value : knob_values_[k]) knob.set(t, value);
    }
  }
  for (const double delay : delay_ms_)
    for (const double jitter : jitter_ms_)
      for (const double loss : loss_percent_)
        shell::parse_netem_flag("--netem", netem_text(delay, jitter, loss, netem_), &warnings_);
  std::sort(warnings_.begin(), warnings_.end());
  warnings_.erase(std::unique(warnings_.begin(), warnings_.end()), warnings_.end());
}

/// With the first seed, which stands for all: whether there is room for bodies hardly hangs on it.
void Grid::check_sessions() const {
  const auto most = static_cast<int>(*std::max_element(peers_.begin(), peers_.end()));
  shell::refuse_surplus_inputs(inputs_, most);
  for (const std::string& name : scenarios_) {
    const shell::LoadedScenario s = shell::load_scenario(name, seeds_.front());
    const auto check_room = [&name, most](const Scene& scene, const std::string& with) {
      const auto spawns = static_cast<int>(scene.avatar.spawns.size());
      if (most > spawns)
        throw UserError("--peers: '" + std::to_string(most) + "' is not allowed for scenario " + name + with +
                        "; give 1 to " + std::to_string(spawns));
    };
    check_room(s.scene, "");
    for (const auto& bodies : bodies_) {
      if (!bodies) continue;
      const std::string count = "--bodies " + std::to_string(*bodies);
      const std::string flag = count + ": " + name;
      // Bodies may leave no room for avatars.
      check_room(scenarios::load(scenarios::with_bodies(s.text, flag, *bodies), flag, seeds_.front()),
                 " with " + count);
    }
    shell::tell_of_paths("padr-lab", inputs_, s.scene);
    for (int p = 0; p < most; ++p)
      shell::load_input(inputs_[static_cast<std::size_t>(p) % inputs_.size()], s.scene, p, seeds_.front());
  }
}

std::string Grid::identify() const {
  Hasher h;
  const auto list = [&h](const auto& values) {
    h.add(static_cast<std::uint64_t>(values.size()));
    for (const auto& v : values) h.add(v);
  };
  const auto numbers = [&h](const std::vector<double>& values) {
    h.add(static_cast<std::uint64_t>(values.size()));
    for (const double v : values) h.add(std::string_view(plain(v)));
  };
  h.add(shell::revision());
  h.add(world::physics_fingerprint());
  for (const std::string& name : scenarios_) {
    h.add(std::string_view(name));
    h.add(std::string_view(shell::load_scenario(name, seeds_.front()).text));
  }
  h.add(static_cast<std::uint64_t>(bodies_.size()));
  for (const auto& b : bodies_) h.add(static_cast<std::uint64_t>(b.value_or(0)));
  list(peers_);
  numbers(delay_ms_);
  numbers(jitter_ms_);
  numbers(loss_percent_);
  h.add(std::string_view(netem_));
  if (const auto trace = point(0).netem.trace.opportunities)
    for (const std::uint32_t ms : *trace) h.add(std::uint64_t{ms});
  for (const std::string& name : techniques_) h.add(std::string_view(shell::describe(shell::technique_of(name))));
  for (std::size_t k = 0; k < knobs_.size(); ++k) {
    h.add(std::string_view(knob_columns_[k]));
    for (const std::string& v : knob_values_[k]) h.add(std::string_view(v));
  }
  list(seeds_);
  numbers({seconds_, settle_seconds_});
  if (watched_) h.add(std::uint64_t{*watched_} + 1);
  for (const std::string& input : inputs_) {
    h.add(std::string_view(input));
    if (const auto path = shell::path_text(input)) h.add(std::string_view(shell::read_file("--input", path->file)));
  }
  return fmt::format("{:08x}", h.value() >> 32U);
}

}  // namespace padr::lab::sweep
