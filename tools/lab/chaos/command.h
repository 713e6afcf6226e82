#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "shell/technique_flags.h"
#include "tools/lab/chaos/harm_table.h"
#include "tools/lab/chaos/lies.h"
#include "tools/lab/chaos/play.h"

namespace padr::lab {

/// `padr-lab chaos`: whole sessions, with everything that can happen to them, on virtual time.
class ChaosCommand {
 public:
  void declare(CLI::App& app);
  /// Returns the exit code: 0, or 1 if something that must hold did not. Throws UserError.
  int run(const std::vector<std::string>& command);

 private:
  void prepare();
  void prepare_liar();
  std::string summary(const std::vector<ChaosOutcome>& outcomes) const;
  HarmTable harm(const std::vector<ChaosOutcome>& outcomes) const;
  ChaosPlay how_of(std::size_t i) const;
  ChaosScript script_of(std::size_t i) const;
  void print(std::size_t i, const ChaosOutcome& outcome, bool shrinks) const;
  std::string json(const std::vector<std::string>& command, const std::vector<ChaosOutcome>& outcomes) const;

  ChaosPlay how_;  ///< but for the scene
  shell::TechniqueFlags technique_;
  std::string scenario_ = "arena";
  std::uint32_t bodies_ = 12;
  std::uint64_t seed_ = 1;
  int runs_ = 1;
  double minutes_ = 2;
  int peers_ = 12;
  int jobs_ = 0;
  int shrink_tries_ = 200;
  bool story_ = false;
  bool cuts_ = false;
  CLI::Option* liar_option_ = nullptr;
  CLI::Option* peers_option_ = nullptr;
  std::string liar_name_;
  bool lies_ = false;
  const Behaviour* liar_ = nullptr;  ///< null: drawn by each script's seed
  std::string json_;
};

}  // namespace padr::lab
