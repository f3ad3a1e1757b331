// Conversion of linear base colours, which tasks and states have, to those of images.
#pragma once

#include <cmath>

#include "core/math/real_functions.h"

namespace engram {

// A level of 0..1 as displays want it, rounded to visible steps.
inline double display_level(double linear) {
  constexpr double kGamma = 2.2;
  constexpr double kSteps = 1 << 20;
  return std::round(real::exp(real::log(linear) / kGamma) * kSteps) / kSteps;
}

}  // namespace engram
