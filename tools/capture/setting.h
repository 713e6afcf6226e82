#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/capture/rebuild.h"
#include "tools/capture/session_log.h"

namespace padr::capture {

/// For --session: decimal, as everything that we print, or hexadecimal with 0x.
CLI::Validator session_number();

/// What padr-peer --keylog has written, for sessions with a key.
void declare_keylogs(CLI::App& app, std::vector<std::string>& keylogs);

/// What the packets may not tell: flags, and how they and a session's Join and Welcome go together.
class SettingFlags {
 public:
  /// `group`: the heading in help texts.
  void declare(CLI::App& app, const std::string& group = "Session");
  const std::optional<int>& session() const { return session_; }
  /// Throws UserError if the scenario is not known, or if a flag contradicts the capture.
  Setting setting(const SessionLog& session_log) const;

 private:
  void refuse_contradictions(const SessionLog& session_log) const;

  std::string scenario_;
  std::optional<std::uint64_t> seed_;
  std::optional<int> session_;
  std::optional<int> wait_peers_;
  std::optional<int> slots_;
  bool avatar_only_ = false;
};

}  // namespace padr::capture
