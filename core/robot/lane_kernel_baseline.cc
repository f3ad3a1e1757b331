// Kernels for every processor: one lane and four; and the choice of a kernel.
#include "core/robot/lane_kernel.h"
#include "core/robot/lane_kernel_body.h"

namespace engram {
namespace {

constexpr LaneKernel kSingle = make_lane_kernel<float>(InstructionSet::kBaseline);
constexpr LaneKernel kKernel = make_lane_kernel<simd::Float>(InstructionSet::kBaseline);

}  // namespace

const LaneKernel& baseline_single_kernel() { return kSingle; }

const LaneKernel* lane_kernel(int lanes) {
  switch (lanes) {
    case 1:  // wider vectors than AVX2's are no faster here
      return lane_kernel(8) != nullptr ? avx2_single_kernel() : &kSingle;
    case 4:
      return &kKernel;
    case 8:
      return is_available(InstructionSet::kAvx2) ? avx2_lane_kernel() : nullptr;
    case 16:
      return is_available(InstructionSet::kAvx512) ? avx512_lane_kernel() : nullptr;
    default:
      return nullptr;
  }
}

const LaneKernel& widest_lane_kernel() {
  int lanes = kMaxLanes;
  while (lane_kernel(lanes) == nullptr) lanes /= 2;
  return *lane_kernel(lanes);
}

const LaneKernel& lane_kernel_for(int robots) {
  if (robots == 1) return *lane_kernel(1);
  int lanes = widest_lane_kernel().lanes;
  while (lanes > 4 && lanes / 2 >= robots) lanes /= 2;
  return *lane_kernel(lanes);
}

}  // namespace engram
