// Sixteen lanes, for processors with AVX-512.
#include "core/robot/lane_kernel.h"

#if defined(__AVX512F__)
#include "core/robot/lane_kernel_body.h"

namespace engram {
namespace {
constexpr LaneKernel kKernel = make_lane_kernel<simd::Float>(InstructionSet::kAvx512);
}  // namespace
const LaneKernel* avx512_lane_kernel() { return &kKernel; }
}  // namespace engram
#else
namespace engram {
const LaneKernel* avx512_lane_kernel() { return nullptr; }
}  // namespace engram
#endif
