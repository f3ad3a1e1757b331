// Robots side by side: the memory of a block of lanes and the kernel that works on it.
#pragma once

#include <algorithm>

#include "core/base/aligned_array.h"
#include "core/base/index.h"
#include "core/robot/lane_kernel.h"

namespace engram {

class LaneBlock {
 public:
  explicit LaneBlock(const LaneKernel& kernel)
      : kernel_(&kernel), vectors_(at(LaneVectors::kCount * kernel.lanes)) {}

  const LaneKernel& kernel() const { return *kernel_; }
  int lanes() const { return kernel_->lanes; }
  double* vectors() { return vectors_.data(); }
  const double* vectors() const { return vectors_.data(); }

  void put(int first_vector, int lane, const double* values, int count) {
    for (int i = 0; i < count; ++i) vectors()[(first_vector + i) * lanes() + lane] = values[i];
  }
  void get(int first_vector, int lane, double* values, int count) const {
    for (int i = 0; i < count; ++i) values[i] = vectors()[(first_vector + i) * lanes() + lane];
  }
  // Fills the lanes from `used` on with what the first one has.
  void pad(int first_vector, int count, int used) {
    for (int i = first_vector; i < first_vector + count; ++i) {
      double* const vector = vectors() + i * lanes();
      std::fill(vector + used, vector + lanes(), vector[0]);
    }
  }
  // The end of a substep is the next one's start.
  void advance() {
    std::copy_n(vectors() + LaneVectors::kEndQ * lanes(), 2 * kRobotJoints * lanes(),
                vectors() + LaneVectors::kQ * lanes());
  }

 private:
  const LaneKernel* kernel_;
  AlignedArray<double> vectors_;
};

}  // namespace engram
