#include "tools/capture/names.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace padr::capture {

std::string_view name_of(wire::SealError why) {
  constexpr std::array<std::string_view, 7> kNames{"", "short", "long", "magic", "version", "kind", "tag"};
  return kNames[static_cast<std::size_t>(why)];
}

std::string_view name_of(wire::Kind kind) {
  constexpr std::array<std::string_view, 3> kNames{"state", "session", "membership"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::string_view name_of(const wire::SessionMessage& message) {
  constexpr std::array<std::string_view, std::variant_size_v<wire::SessionMessage>> kNames{
      "join", "welcome", "redirect", "refuse", "ping", "pong", "start", "ready", "bye"};
  return kNames[message.index()];
}

std::string_view name_of(const wire::MembershipMessage& message) {
  constexpr std::array<std::string_view, std::variant_size_v<wire::MembershipMessage>> kNames{
      "pull", "piece", "enter", "poll", "answer", "fetch", "fetched", "probe"};
  return kNames[message.index()];
}

std::string Table::text() const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string out;
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - row[i].size(), ' ');
      out += "  ";
      out += i == 0 ? row[i] + space : space + row[i];
    }
    out.erase(out.find_last_not_of(' ') + 1);
    out += '\n';
  }
  return out;
}

std::string fixed(double v, int digits) {
  if (!std::isfinite(v)) return "-";
  std::array<char, 400> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), v, std::chars_format::fixed, digits).ptr;
  return {text.data(), end};
}

}  // namespace padr::capture
