// Fills one row of floats from the simulation's doubles, from left to right.
#pragma once

#include <Eigen/Dense>

namespace engram::tasks {

class RowWriter {
 public:
  explicit RowWriter(float* out) : out_(out) {}

  void add(double value) { *out_++ = static_cast<float>(value); }
  void add(const double* values, int count) {
    for (int i = 0; i < count; ++i) add(values[i]);
  }
  void add(const Eigen::Vector3d& vector) { add(vector.data(), 3); }

 private:
  float* out_;
};

}  // namespace engram::tasks
