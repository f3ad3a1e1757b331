// Eight lanes and one, for processors with AVX-512.
#include "core/robot/lane_kernel.h"

#if defined(__AVX512F__)
#include "core/robot/lane_kernel_body.h"

namespace engram {
namespace {
constexpr LaneKernel kKernel = make_lane_kernel<simd::Double>(InstructionSet::kAvx512);
constexpr LaneKernel kSingle = make_lane_kernel<double>(InstructionSet::kAvx512);
}  // namespace
const LaneKernel* avx512_lane_kernel() { return &kKernel; }
const LaneKernel* avx512_single_kernel() { return &kSingle; }
}  // namespace engram
#else
namespace engram {
const LaneKernel* avx512_lane_kernel() { return nullptr; }
const LaneKernel* avx512_single_kernel() { return nullptr; }
}  // namespace engram
#endif
