// From linear base colours, which is what tasks and states have, to those of pictures.
#pragma once

#include <cmath>

namespace engram {

// A level of 0..1 as displays want it. Rounded, so that the last bits of std::pow, which differ
// from machine to machine, reach neither documents nor pictures.
inline double display_level(double linear) {
  constexpr double kGamma = 2.2;
  constexpr double kSteps = 1 << 20;
  return std::round(std::pow(linear, 1 / kGamma) * kSteps) / kSteps;
}

}  // namespace engram
