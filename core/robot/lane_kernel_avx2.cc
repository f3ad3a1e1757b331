// Four lanes, for processors with AVX2.
#include "core/robot/lane_kernel.h"

#if defined(__AVX2__)
#include "core/robot/lane_kernel_body.h"

namespace engram {
namespace {
constexpr LaneKernel kKernel = make_lane_kernel<simd::Double>(InstructionSet::kAvx2);
}
const LaneKernel* avx2_lane_kernel() { return &kKernel; }
}  // namespace engram
#else
namespace engram {
const LaneKernel* avx2_lane_kernel() { return nullptr; }
}  // namespace engram
#endif
