// Lengths of vectors of floats with the same bits on every processor. Eigen's depend on it: how it
// adds floats follows the width of the processor's vectors, and how those add themselves up. (Its
// sums of doubles are the same everywhere, two at a time.)
#pragma once

#include <cmath>

namespace engram {

inline float length_of_three(const float* v) {
  return std::sqrt(v[0] * v[0] + (v[1] * v[1] + v[2] * v[2]));
}

// The length of all `at(i)`, i < size.
template <typename Component>
float length_of(int size, const Component& at) {
  const auto square = [&at](int i) { return at(i) * at(i); };
  const int even = size / 4 * 4;
  float sum = size > 0 ? square(0) : 0;
  if (even > 0) {
    float lanes[4] = {sum, square(1), square(2), square(3)};
    for (int i = 4; i < even; ++i) lanes[i % 4] += square(i);
    sum = (lanes[0] + lanes[2]) + (lanes[1] + lanes[3]);
  }
  for (int i = even > 0 ? even : 1; i < size; ++i) sum += square(i);
  return std::sqrt(sum);
}

}  // namespace engram
