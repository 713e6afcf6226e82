#pragma once

namespace padr {

/// Sine and cosine of one angle.
struct SinCos {
  double sin = 0;
  double cos = 1;
};

// The C library picks other instructions on other processors, and with them other last bits. These use nothing but
// IEEE 754 additions, multiplications and divisions of doubles in a fixed order, so that they are the same to the bit
// wherever doubles are (compiled without contraction, as all of this project is). Rounded to float they are within half
// a unit in the last place and a little: as good as the C library's.

/// `x` in radians; exact argument reduction below 1e6, and never worse than its own rounding beyond. Not finite: NaN.
SinCos sin_cos(double x);
/// The angle of the point (x, y) in radians, -pi .. pi, with the C standard's special cases.
double arc_tangent(double y, double x);
/// The logarithm to base 2 of a positive number that is not tiny (below 2^-1022), to within 1e-15 of itself or of 1.
double binary_logarithm(double x);

}  // namespace padr
