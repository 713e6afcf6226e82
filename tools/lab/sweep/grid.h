#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/link/netem_spec.h"
#include "common/model/ids.h"
#include "common/model/technique.h"

namespace padr::lab::sweep {

/// A grid as flags give it: lists as text, see values.h. Empty: not given, one default value.
struct GridText {
  std::string scenarios = "arena";
  std::string bodies;
  std::string peers = "2";
  std::string delay;
  std::string jitter;
  std::string loss;
  std::string netem;  ///< further words for every run, no list
  std::string techniques = "full";
  std::vector<std::string> knobs;  ///< one for each of shell::knobs(); empty: as the technique has it
  std::string seeds = "1";
  double seconds = 60;
  double settle_seconds = 0;
  std::vector<std::string> inputs;  ///< dealt round to the peers; no list
  std::optional<int> watch;         ///< only what this peer sees counts, and only while there is input
};

/// One run of a grid.
struct Point {
  std::string scenario;
  std::optional<std::uint32_t> bodies;  ///< in all; as the scenario has them if not given
  int peers = 0;
  double delay_ms = 0;
  double jitter_ms = 0;
  std::optional<double> loss_percent;  ///< nothing: --netem has a model of loss, with no share of its own
  std::string technique_name;          ///< as given, with the knobs that came with it
  std::vector<std::string> knobs;      ///< values of the knobs that are in the grid
  std::uint64_t seed = 0;
  Technique technique;  ///< with its knobs set
  link::NetemSpec netem;
};

/// All combinations of some lists, in one order: seeds change fastest, scenarios slowest.
class Grid {
 public:
  /// Checks everything that can be checked without running. Throws UserError that names the flag, the value and what is
  /// allowed.
  explicit Grid(const GridText& text);

  std::size_t size() const { return size_; }
  Point point(std::size_t index) const;
  /// Flags of the knobs that are in the grid, without dashes before and with '_' for those within.
  const std::vector<std::string>& knob_columns() const { return knob_columns_; }
  /// Name and value of the columns of flags that are no lists and were given: all rows have them alike.
  const std::vector<std::pair<std::string, std::string>>& given() const { return given_; }
  double seconds() const { return seconds_; }
  double settle_seconds() const { return settle_seconds_; }
  const std::vector<std::string>& inputs() const { return inputs_; }
  std::optional<PeerId> watched() const { return watched_; }
  /// Eight hexadecimal digits that two grids have in common only if all their runs are the same: of the lists, the
  /// texts of scenarios and paths, the program's revision and this machine's physics.
  const std::string& id() const { return id_; }
  /// What is legal but doubtful in some of the runs' networks.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void look_into_netem(const GridText& t);
  void take_from_netem(Point& p) const;
  void note_given(const GridText& t);
  void check_sessions() const;
  void check_techniques();
  std::string identify() const;

  std::vector<std::string> scenarios_;
  std::vector<std::optional<std::uint32_t>> bodies_;
  std::vector<std::uint64_t> peers_;
  std::vector<double> delay_ms_, jitter_ms_, loss_percent_;
  std::string netem_;
  std::vector<std::string> techniques_;
  std::vector<std::size_t> knobs_;  ///< places in shell::knobs()
  std::vector<std::string> knob_columns_;
  std::vector<std::vector<std::string>> knob_values_;  ///< by knob of the grid
  std::vector<std::uint64_t> seeds_;
  double seconds_;
  double settle_seconds_;
  std::vector<std::string> inputs_;
  std::optional<PeerId> watched_;
  bool netem_has_delay_ = false;
  bool netem_has_loss_ = false;
  std::vector<std::pair<std::string, std::string>> given_;
  std::size_t size_ = 0;
  std::string id_;
  std::vector<std::string> warnings_;
};

}  // namespace padr::lab::sweep
