#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace padr::shell {

/// A file of shell/link_traces, built in.
struct EmbeddedLinkTrace {
  std::string_view name;  ///< file name without its ending
  std::string_view text;
};
/// All of them, sorted by name.
std::span<const EmbeddedLinkTrace> embedded_link_traces();

/// The names of those built in, for messages: "a, b, c".
std::string link_trace_names();

/// Reads a file that a user has named. Throws UserError.
using ReadFile = std::function<std::string(const std::string& file)>;

/// The opportunities of a link trace (see link::TraceSpec): the one built in by this name, else the file, if there is
/// `read`. The form is mahimahi's: on each line a whole number of milliseconds, none less than the one before, the last
/// above 0. Throws UserError: one line that says what is allowed, and names file and line.
std::shared_ptr<const std::vector<std::uint32_t>> load_link_trace(std::string_view name, const ReadFile& read);

}  // namespace padr::shell
