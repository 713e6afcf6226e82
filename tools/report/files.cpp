#include "tools/report/files.h"

#include <algorithm>

#include "shell/files.h"

namespace padr::report {
namespace {

// The largest trace: hours of a busy session. A larger one and its figures would not fit in memory.
constexpr std::size_t kMostBytes = std::size_t{4} << 30U;

}  // namespace

TraceBytes read_trace(const std::string& file) {
  const std::string text = shell::read_file("TRACE", file, kMostBytes);
  TraceBytes t{file, std::vector<std::byte>(text.size())};
  std::transform(text.begin(), text.end(), t.bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
  return t;
}

}  // namespace padr::report
