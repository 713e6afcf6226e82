#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

namespace padr::lab::figures {

/// Fixed digits; "-" for what there is no number for.
inline std::string fixed(double v, int digits) {
  if (!std::isfinite(v)) return "-";
  std::array<char, 64> text{};
  const int n = std::snprintf(text.data(), text.size(), "%.*f", digits, v);
  return {text.data(), static_cast<std::size_t>(n)};
}

/// 0.5 is "50 %".
inline std::string percent(double v) {
  return std::isfinite(v) ? fixed(100 * v, 0) + " %" : "-";
}

}  // namespace padr::lab::figures
