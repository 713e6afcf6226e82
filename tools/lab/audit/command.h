#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace padr::lab {

/// `padr-lab audit`: what members signed, held against physics and against one another.
class AuditCommand {
 public:
  void declare(CLI::App& app);
  /// Returns the exit code: 0, or 1 if there are findings. Throws UserError.
  int run(const std::vector<std::string>& command) const;

 private:
  std::vector<std::string> traces_;
  std::string json_;
  int worst_ = 3;
  bool no_pushes_ = false;
};

}  // namespace padr::lab
