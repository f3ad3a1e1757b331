// Robots side by side: the memory of a block of lanes and the kernel that works on it.
#pragma once

#include <algorithm>

#include "core/base/aligned_array.h"
#include "core/robot/lane_kernel.h"

namespace engram {

class LaneBlock {
 public:
  explicit LaneBlock(const LaneKernel& kernel)
      : kernel_(&kernel), rows_(static_cast<std::size_t>(LaneRows::kCount * kernel.lanes)) {}

  const LaneKernel& kernel() const { return *kernel_; }
  int lanes() const { return kernel_->lanes; }
  double* rows() { return rows_.data(); }
  const double* rows() const { return rows_.data(); }

  void put(int first_row, int lane, const double* values, int count) {
    for (int i = 0; i < count; ++i) rows()[(first_row + i) * lanes() + lane] = values[i];
  }
  void get(int first_row, int lane, double* values, int count) const {
    for (int i = 0; i < count; ++i) values[i] = rows()[(first_row + i) * lanes() + lane];
  }
  // Fills the lanes from `used` on with what the first one has.
  void pad(int first_row, int count, int used) {
    for (int i = first_row; i < first_row + count; ++i) {
      double* const row = rows() + i * lanes();
      std::fill(row + used, row + lanes(), row[0]);
    }
  }
  // The end of a substep is the next one's start.
  void advance() {
    std::copy_n(rows() + LaneRows::kEndQ * lanes(), 2 * kRobotJoints * lanes(),
                rows() + LaneRows::kQ * lanes());
  }

 private:
  const LaneKernel* kernel_;
  AlignedArray<double> rows_;
};

}  // namespace engram
