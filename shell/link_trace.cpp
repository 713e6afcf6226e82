#include "shell/link_trace.h"

#include <algorithm>
#include <charconv>

#include "common/model/user_error.h"
#include "shell/netem_words.h"

namespace padr::shell {
namespace {

[[noreturn]] void fail(const std::string& file, std::size_t line, const std::string& message) {
  throw UserError(file + ":" + std::to_string(line) + ": " + message);
}

std::vector<std::uint32_t> parse(std::string_view text, const std::string& file) {
  std::vector<std::uint32_t> times;
  std::size_t number = 0;
  while (!text.empty()) {
    ++number;
    std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    std::uint32_t ms = 0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), ms);
    if (error != std::errc() || end != line.data() + line.size()) {
      fail(file, number, words::quoted(line) + " is no time, allowed: a whole number of milliseconds, 0 to 4294967295");
    }
    if (!times.empty() && ms < times.back()) {
      fail(file, number,
           std::to_string(ms) + " after " + std::to_string(times.back()) +
               ", allowed: the time of the line before, or later");
    }
    times.push_back(ms);
  }
  if (times.empty()) fail(file, 1, "the file is empty, allowed: lines with a time in milliseconds each");
  if (times.back() == 0) fail(file, number, "the last time is 0, allowed: 1 or later, as the trace is so long");
  return times;
}

}  // namespace

std::string link_trace_names() {
  std::string all;
  for (const EmbeddedLinkTrace& t : embedded_link_traces()) all += (all.empty() ? "" : ", ") + std::string(t.name);
  return all;
}

std::shared_ptr<const std::vector<std::uint32_t>> load_link_trace(std::string_view name, const ReadFile& read) {
  const std::string file(name);
  for (const EmbeddedLinkTrace& t : embedded_link_traces()) {
    if (t.name == name) return std::make_shared<const std::vector<std::uint32_t>>(parse(t.text, file));
  }
  const std::string unknown = "not one of " + link_trace_names();
  if (!read) throw UserError(unknown + "; files can be named on a command line only");
  std::string text;
  try {
    text = read(file);
  } catch (const UserError& e) {
    throw UserError(unknown + "; " + e.what());
  }
  return std::make_shared<const std::vector<std::uint32_t>>(parse(text, file));
}

}  // namespace padr::shell
