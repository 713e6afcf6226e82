#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace padr::shell {

/// Gives `app` a --version flag that prints program name, version and revision.
void add_version_flag(CLI::App& app, const std::string& program);

/// Parses. False if it was a request for help or version, which has then been printed: exit with 0.
/// Throws UserError with one line for anything wrong.
bool parse(CLI::App& app, int argc, const char* const* argv);

/// For whole numbers from 0: CLI11 by itself takes "-1" for the largest there is.
CLI::Validator whole_number();
/// For numbers from `low` to `high` in `unit`; --help shows the two. Unlike CLI::Range it does not let NaN pass.
CLI::Validator between(double low, double high, const std::string& unit);
/// The same without a unit.
CLI::Validator range(double low, double high);

/// The command line as it was given, for results that say where they came from.
std::vector<std::string> command_of(int argc, const char* const* argv);
/// The same in one line, quoted where a POSIX shell needs it.
std::string shell_line(const std::vector<std::string>& command);

}  // namespace padr::shell
