#include "shell/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace padr::shell {
namespace {

/// Bytes of the well-formed sequence at the begin of `s`; 0 if there is none.
std::size_t sequence_length(std::string_view s) {
  const auto byte = [s](std::size_t i) { return static_cast<unsigned char>(s[i]); };
  const unsigned lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t n = lead < 0xC2 ? 0U : (lead < 0xE0 ? 2U : (lead < 0xF0 ? 3U : (lead < 0xF5 ? 4U : 0U)));
  if (n == 0 || n > s.size()) return 0;
  for (std::size_t i = 1; i < n; ++i)
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
  const bool overlong = (lead == 0xE0 && byte(1) < 0xA0) || (lead == 0xF0 && byte(1) < 0x90);
  const bool surrogate = lead == 0xED && byte(1) >= 0xA0;
  const bool beyond = lead == 0xF4 && byte(1) >= 0x90;
  return overlong || surrogate || beyond ? 0 : n;
}

}  // namespace

std::string fixed(double v, int digits) {
  return fmt::format("{:.{}f}", v, digits);
}

std::string fixed_or_dash(double v, int digits) {
  return std::isfinite(v) ? fixed(v, digits) : "-";
}

std::string hex(std::uint64_t v) {
  return fmt::format("{:016x}", v);
}

std::string valid_utf8(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t n = sequence_length(text);
    out += n == 0 ? std::string_view("\xEF\xBF\xBD") : text.substr(0, n);
    text.remove_prefix(n == 0 ? 1 : n);
  }
  return out;
}

std::string Table::text() const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string s;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string gap(widths[c] - row[c].size(), ' ');
      line += c == 0 ? row[c] + gap : "  " + gap + row[c];
    }
    s += "  " + line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
  }
  return s;
}

}  // namespace padr::shell
