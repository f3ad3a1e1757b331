// The mean of results.
#pragma once

#include <numeric>
#include <vector>

namespace engram {

// 0 of none.
template <class T>
double mean(const std::vector<T>& values) {
  if (values.empty()) return 0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace engram
