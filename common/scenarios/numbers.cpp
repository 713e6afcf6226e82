#include "common/scenarios/numbers.h"

#include <array>
#include <charconv>
#include <cmath>

namespace padr::scenarios {
namespace {

template <typename... Args>
std::string text(Args... args) {
  std::array<char, 64> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), args...).ptr;
  return {buffer.data(), end};
}

/// Whether people would rather read it without an exponent.
bool everyday(double v) {
  return std::abs(v) >= 1e-4 && std::abs(v) < 1e12;
}

}  // namespace

std::string number_text(double v) {
  return everyday(v) ? text(v, std::chars_format::fixed) : text(v);
}

std::string number_text(float v) {
  return everyday(static_cast<double>(v)) ? text(v, std::chars_format::fixed) : text(v);
}

std::string rough_text(double v) {
  return text(v, std::chars_format::general, 3);
}

}  // namespace padr::scenarios
