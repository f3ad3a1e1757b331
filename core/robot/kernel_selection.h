// Selection of a kernel that the robots of a batch fill, and kernels of one lane.
#pragma once

#include "core/robot/lane_kernel.h"

namespace engram {

// The widest kernel of the processor of which N robots fill at least half.
const LaneKernel& lane_kernel_for(int robots);

// Kernels of one lane; null where this library was built without the instruction set.
const LaneKernel& baseline_single_kernel();
const LaneKernel* avx2_single_kernel();
const LaneKernel* avx512_single_kernel();

}  // namespace engram
