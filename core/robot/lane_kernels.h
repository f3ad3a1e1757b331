// The kernels of wide instruction sets; null where this library was built without them.
#pragma once

#include "core/robot/lane_kernel.h"

namespace engram {

const LaneKernel* avx2_lane_kernel();
const LaneKernel* avx512_lane_kernel();

}  // namespace engram
