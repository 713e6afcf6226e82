#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/link/netem_spec.h"

namespace padr::shell {

/// parse_netem for the value of a flag: errors and warnings begin with the flag's name. It reads files of link traces.
link::NetemSpec parse_netem_flag(std::string_view flag, std::string_view text, std::vector<std::string>* warnings);
/// The same for a field of what somebody else has sent, who must not name files here.
link::NetemSpec parse_netem_field(std::string_view field, std::string_view text, std::vector<std::string>* warnings);

/// For messages: the canonical form in quotes, or "unimpaired".
std::string describe(const link::NetemSpec& spec);

/// --netem SPEC and --netem-seed N.
class NetemFlags {
 public:
  void declare(CLI::App& app);
  /// After parsing. Throws UserError; legal but doubtful things are added to `warnings`.
  link::NetemSpec spec(std::vector<std::string>* warnings) const;
  /// As it was written.
  const std::string& text() const { return text_; }
  /// `fallback` unless it was given.
  std::uint64_t seed(std::uint64_t fallback) const { return seed_.value_or(fallback); }

 private:
  std::string text_;
  std::optional<std::uint64_t> seed_;
};

/// One paragraph on the grammar, for help texts.
std::string netem_help();

}  // namespace padr::shell
