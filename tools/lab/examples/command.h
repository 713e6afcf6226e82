#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "shell/netem_flags.h"

namespace padr::lab {

/// `padr-lab examples`: the paper's examples as stories, with what model errors cost in each, and films of them.
class ExamplesCommand {
 public:
  void declare(CLI::App& app);
  /// Returns the exit code. Throws UserError.
  int run(const std::vector<std::string>& command);

 private:
  std::string out_;
  std::string stories_ = "ball,dominoes,van,carton,proxy,ball-missed,dominoes-missed,van-missed,carton-missed";
  int takes_ = 8;
  int jobs_ = 0;
  std::string netem_;
  std::string json_;
  bool no_pictures_ = false;
};

}  // namespace padr::lab
