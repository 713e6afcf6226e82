#include "common/model/portable_math.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace padr {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// pi/2 in two parts (Cody and Waite, Software Manual for the Elementary Functions): the first has 33 bits, so that its
// product with a number of quarter turns below 2^20 is exact.
constexpr double kQuarterHigh = 0x1.921FB544p+0;
constexpr double kQuarterLow = 0x1.0B4611A626331p-34;

/// std::floor, which is a call on processors without SSE 4.1, and this is called several times a step and body.
double floor_of(double x) {
  constexpr double kWholeAnyway = 4503599627370496.0;  // 2^52
  if (std::fabs(x) >= kWholeAnyway) return x;
  const auto towards_zero = static_cast<double>(static_cast<std::int64_t>(x));
  return towards_zero > x ? towards_zero - 1 : towards_zero;
}

/// c[0] + c[1] z + c[2] z^2 + ...
template <std::size_t N>
double polynomial(double z, const std::array<double, N>& c) {
  double sum = c[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) sum = sum * z + c[i];
  return sum;
}

// Taylor: on an eighth of a turn the first term left out is below 1e-16.
constexpr std::array<double, 8> kSine{
    1, -1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880, -1.0 / 39916800, 1.0 / 6227020800.0, -1.0 / 1307674368000.0};
constexpr std::array<double, 9> kCosine{1,
                                        -1.0 / 2,
                                        1.0 / 24,
                                        -1.0 / 720,
                                        1.0 / 40320,
                                        -1.0 / 3628800,
                                        1.0 / 479001600.0,
                                        -1.0 / 87178291200.0,
                                        1.0 / 20922789888000.0};
constexpr std::array<double, 9> kArcTangent{1,         -1.0 / 3, 1.0 / 5,   -1.0 / 7, 1.0 / 9,
                                            -1.0 / 11, 1.0 / 13, -1.0 / 15, 1.0 / 17};
// Of atanh(z) / z in z^2: on z up to 0.172 the first term left out is below 1e-17.
constexpr std::array<double, 11> kAreaTangent{1,        1.0 / 3,  1.0 / 5,  1.0 / 7,  1.0 / 9, 1.0 / 11,
                                              1.0 / 13, 1.0 / 15, 1.0 / 17, 1.0 / 19, 1.0 / 21};

/// Of 0 .. 1. On 0 .. 1/5 the series is good to 1e-14; the rest is brought there by the addition theorem.
double arc_tangent_of_ratio(double z) {
  constexpr double kSplit = 0.41421356237309503;   // tan(pi/8)
  constexpr double kMiddle = 0.19891236737965800;  // tan(pi/16)
  double turned = 0;
  if (z > kSplit) {
    z = (z - 1) / (z + 1);
    turned = kPi / 4;
  }
  if (z > kMiddle) {
    z = (z - kSplit) / (1 + z * kSplit);
    turned += kPi / 8;
  } else if (z < -kMiddle) {
    z = (z + kSplit) / (1 - z * kSplit);
    turned -= kPi / 8;
  }
  return turned + z * polynomial(z * z, kArcTangent);
}

}  // namespace

SinCos sin_cos(double x) {
  if (x == 0) return {x, 1};  // most of what does not turn never has
  if (!std::isfinite(x)) return {kNaN, kNaN};
  const double quarters = floor_of(x * (2 / kPi) + 0.5);
  const double r = (x - quarters * kQuarterHigh) - quarters * kQuarterLow;
  const double z = r * r;
  const double s = r * polynomial(z, kSine);
  const double c = polynomial(z, kCosine);
  const double turn = quarters - 4 * floor_of(quarters / 4);  // 0 .. 3
  if (turn == 0) return {s, c};
  if (turn == 1) return {c, -s};
  if (turn == 2) return {-s, -c};
  return {-c, s};
}

double arc_tangent(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return kNaN;
  double ay = std::fabs(y);
  double ax = std::fabs(x);
  if (std::isinf(ax) && std::isinf(ay)) ax = ay = 1;
  double angle = 0;
  if (ax > ay) {
    angle = arc_tangent_of_ratio(std::isinf(ax) ? 0 : ay / ax);
  } else if (ay > 0) {
    angle = kPi / 2 - arc_tangent_of_ratio(std::isinf(ay) ? 0 : ax / ay);
  }
  if (std::signbit(x)) angle = kPi - angle;
  return std::copysign(angle, y);
}

double binary_logarithm(double x) {
  constexpr double kHalfRoot = 0.70710678118654752;  // sqrt(1/2)
  constexpr double kTwoOverLn2 = 2.8853900817779268;
  int exponent = 0;
  double mantissa = std::frexp(x, &exponent);  // 1/2 .. 1
  if (mantissa < kHalfRoot) {
    mantissa *= 2;
    --exponent;
  }
  // ln m = 2 atanh((m - 1) / (m + 1))
  const double z = (mantissa - 1) / (mantissa + 1);
  return exponent + kTwoOverLn2 * z * polynomial(z * z, kAreaTangent);
}

}  // namespace padr
