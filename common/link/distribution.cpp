#include "common/link/distribution.h"

#include <algorithm>

namespace padr::link {

namespace {

constexpr double kPi = 3.14159265358979323846;

/// exp(-y) for 0 <= y <= 8, by the series of exp(-y/16), squared four times.
constexpr double exp_minus(double y) {
  double term = 1;
  double sum = 1;
  for (int n = 1; n < 20; ++n) {
    term *= -(y / 16) / n;
    sum += term;
  }
  for (int i = 0; i < 4; ++i) sum *= sum;
  return sum;
}

/// Newton's method; v > 0.
constexpr double square_root(double v) {
  double x = v < 1 ? 1 : v;
  for (int i = 0; i < 60; ++i) x = (x + v / x) / 2;
  return x;
}
constexpr double cube_root(double v) {
  double x = v < 1 ? 1 : v;
  for (int i = 0; i < 60; ++i) x = (2 * x + v / (x * x)) / 3;
  return x;
}

double normal_density(double x) {
  static const double scale = 1 / square_root(2 * kPi);
  return scale * exp_minus(x * x / 2);
}

/// P(0 < X < x) of a standard normal X, 0 <= x <= 4: density times the series x + x^3/3 + x^5/(3*5) + ...
double normal_mass(double x) {
  double term = x;
  double sum = x;
  for (int n = 3; n < 160; n += 2) {
    term *= x * x / n;
    sum += term;
  }
  return normal_density(x) * sum;
}

/// Entry i of the upper half by Newton's method from the entry before it. The distribution function is concave
/// there, so the steps come from below and never overshoot.
std::array<double, 4096> normal_quantiles() {
  std::array<double, 4096> q{};
  double x = 0;
  for (std::size_t i = 2048; i < 4096; ++i) {
    const double wanted = (static_cast<double>(i) + 0.5) / 4096 - 0.5;
    for (int step = 0; step < 8; ++step) x += (wanted - normal_mass(x)) / normal_density(x);
    q[i] = x;
    q[4095 - i] = -x;
  }
  return q;
}

double pareto_quantile(std::size_t i) {
  const double above = 1 - (static_cast<double>(i) + 0.5) / 4096;
  return std::min((1 / cube_root(above) - 1.5) * 4 / 3, 32767.0 / kDistributionScale);
}

std::int16_t scaled(double v) {
  const double s = v * kDistributionScale;
  return static_cast<std::int16_t>(std::clamp(s < 0 ? s - 0.5 : s + 0.5, -32768.0, 32767.0));
}

struct Tables {
  DistributionTable normal{}, pareto{}, paretonormal{};
  Tables() {
    const auto n = normal_quantiles();
    for (std::size_t i = 0; i < normal.size(); ++i) {
      const double p = pareto_quantile(i);
      normal[i] = scaled(n[i]);
      pareto[i] = scaled(p);
      paretonormal[i] = scaled(0.25 * n[i] + 0.75 * p);
    }
  }
};

}  // namespace

const DistributionTable* distribution_table(Distribution distribution) {
  static const Tables tables;
  switch (distribution) {
    case Distribution::kUniform:
      return nullptr;
    case Distribution::kNormal:
      return &tables.normal;
    case Distribution::kPareto:
      return &tables.pareto;
    case Distribution::kParetoNormal:
      return &tables.paretonormal;
  }
  return nullptr;
}

Nanos distributed(Nanos mean, Nanos jitter, const DistributionTable* table, std::uint32_t random) {
  if (jitter == 0) return mean;
  if (table == nullptr) return mean - jitter + static_cast<Nanos>(random % static_cast<std::uint32_t>(2 * jitter));
  const Nanos product = jitter * (*table)[random % table->size()];
  const Nanos half = product < 0 ? -kDistributionScale / 2 : kDistributionScale / 2;
  return mean + (product + half) / kDistributionScale;
}

}  // namespace padr::link
