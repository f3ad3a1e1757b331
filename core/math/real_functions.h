// Functions of real numbers with the same bits on every processor and with every C library. Those
// of the C library differ in their last bits. Only what IEEE 754 fixes to the bit is taken from it:
// sqrt, floor, fmod and the like.
#pragma once

#include <cmath>

namespace engram::real {

// Zeros, infinities and NaN are treated as the C library does. All need rounding to nearest.

// Within 1.2e-16, the tangent within three units in the last place. x in rad; beyond 1e5 it is
// taken modulo the double nearest to 2 pi.
double sin(double x);
double cos(double x);
double tan(double x);

// Within one unit in the last place.
double exp(double x);
double log(double x);

// Within three.
double asin(double x);
double atan2(double y, double x);
double tanh(double x);

// For lengths: squares must be neither too large nor too small for a double.
inline double hypot(double x, double y) { return std::sqrt(x * x + y * y); }
inline double hypot(double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); }

}  // namespace engram::real
