#pragma once

#include <functional>
#include <string_view>

namespace padr::shell {

/// Exit codes of all programs.
inline constexpr int kExitFine = 0;
inline constexpr int kExitFailure = 1;  ///< something went wrong while running
inline constexpr int kExitUsage = 2;    ///< a mistake in a flag or in a file that a flag names

/// Throws the std::system_error that says so, by errno if it is set.
[[noreturn]] void cannot_write_to_standard_output();

/// Runs `body` and returns its exit code. A padr::UserError becomes one line on standard error and kExitUsage, any
/// other exception (the operating system's among them) one line and kExitFailure.
int run_main(std::string_view program, const std::function<int()>& body);

}  // namespace padr::shell
