#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/link/netem_spec.h"
#include "common/model/scene.h"
#include "common/model/technique.h"
#include "common/sync/updates.h"
#include "common/trace/fidelity.h"
#include "common/trace/metrics.h"
#include "tools/lab/figures/score.h"

// The paper's setting: two peers, of which the first drives its avatar and the second watches.
namespace padr::lab::figures {

/// A technique under test, with the setting that tells it from others of its name.
struct Setting {
  std::string id;     ///< for files and keys: letters, digits, '-' and '.'
  std::string title;  ///< for people, with the technique's name first
  Technique technique;
};

/// What the avatar is driven by, in which world.
struct Case {
  std::string id;     ///< for files: letters, digits and '-'
  std::string title;  ///< for people
  std::string kind;   ///< of input: "recorded" or the generator's name
  std::string input;  ///< as the flag takes it
  std::uint64_t seed = 0;
  Scene scene;
};

struct FigureRun {
  trace::InconsistencySeries watched;  ///< of the second peer's view, ticks 1 .. N
  trace::FidelitySeries fidelity;      ///< of the same view and ticks
  trace::PccSeries pcc;                ///< of the driven avatar, same ticks
  std::vector<float> threshold_m;      ///< in force for the avatar, by tick
  std::vector<bool> touching;          ///< whether the avatar touches a body, by tick
  std::vector<Vec2> path;              ///< of the avatar in its own peer's view, by tick, m
  std::vector<BodyState> bodies_end;   ///< by entity id, in the same view

  std::array<std::uint64_t, sync::kCauses> updates_by_cause{};  ///< told by the first peer
  std::uint64_t updates = 0;
  std::uint64_t datagrams = 0;   ///< that it sent
  std::uint64_t wire_bytes = 0;  ///< of them, IP and UDP headers included
  PredictionScore score;
  std::uint64_t confirmed_mismatches = 0;  ///< must be 0
};

/// Runs `ticks` of it. Deterministic. Throws UserError if the input cannot be read.
FigureRun run_figure(const Case& c, const Setting& s, const link::NetemSpec& netem, Tick ticks);

/// The `padr-lab run` that prints what this case has come to with this setting. `scenario` and `netem` as the flags
/// take them.
std::string run_command(const Case& c, const Setting& s, const std::string& scenario, const std::string& netem,
                        Tick ticks);

/// avatar-only and fixed at each of the paper's thresholds, adaptive with each predictor, full.
std::vector<Setting> figure_settings();
/// The one with this id; it is there.
std::size_t setting_index(const std::vector<Setting>& settings, const std::string& id);

/// Of the adaptive setting with this predictor.
std::string adaptive_id(const std::string& predictor);

/// The paper's three thresholds, as the flag takes them, loosest first; m.
inline constexpr std::array<const char*, 3> kThresholds{"0.8", "0.5", "0.3"};
/// The predictors compared; the first is that of `adaptive` by default.
inline constexpr std::array<const char*, 4> kPredictors{"lookahead", "density", "path-density", "pcc"};

}  // namespace padr::lab::figures
