// Eight lanes and one, for processors with AVX2.
#include "core/robot/lane_kernel.h"

#if defined(__AVX2__)
#include "core/robot/lane_kernel_body.h"

namespace engram {
namespace {
constexpr LaneKernel kKernel = make_lane_kernel<simd::Float>(InstructionSet::kAvx2);
constexpr LaneKernel kSingle = make_lane_kernel<float>(InstructionSet::kAvx2);
}  // namespace
const LaneKernel* avx2_lane_kernel() { return &kKernel; }
const LaneKernel* avx2_single_kernel() { return &kSingle; }
}  // namespace engram
#else
namespace engram {
const LaneKernel* avx2_lane_kernel() { return nullptr; }
const LaneKernel* avx2_single_kernel() { return nullptr; }
}  // namespace engram
#endif
