#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace padr::capture {

class Captures;

/// A subcommand: declares its flags, and runs if it was asked for. Returns the exit code; throws UserError.
using Run = std::function<int(const std::vector<std::string>& command)>;

Run declare_summary(CLI::App& app);
Run declare_timeline(CLI::App& app);
Run declare_rebuild(CLI::App& app);
Run declare_compare(CLI::App& app);
Run declare_export(CLI::App& app);
Run declare_follow(CLI::App& app);

/// The captures to read, one or more.
void declare_captures(CLI::App& app, std::vector<std::string>& files, std::vector<std::string>& keylogs);
/// Sealed datagrams that were not read, if they are so many that a command may lack what is in them: a few that are
/// damaged look so, too.
std::uint64_t many_sealed_unread(const Captures& captures);
/// Says on standard error what of the captures could not be read, and of which datagrams no --keylog has the keys; the
/// exit code: failure if files are not whole.
int warn_unread(const Captures& captures);

}  // namespace padr::capture
