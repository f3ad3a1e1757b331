// Kernels for every processor: one lane and two; and the choice of a kernel.
#include "core/robot/lane_kernel.h"
#include "core/robot/lane_kernel_body.h"

namespace engram {
namespace {

constexpr LaneKernel kSingle = make_lane_kernel<double>(InstructionSet::kBaseline);
constexpr LaneKernel kKernel = make_lane_kernel<simd::Double>(InstructionSet::kBaseline);

}  // namespace

const LaneKernel& baseline_single_kernel() { return kSingle; }

const LaneKernel* lane_kernel(int lanes) {
  switch (lanes) {
    case 1:
      if (lane_kernel(8) != nullptr) return avx512_single_kernel();
      return lane_kernel(4) != nullptr ? avx2_single_kernel() : &kSingle;
    case 2:
      return &kKernel;
    case 4:
      return is_available(InstructionSet::kAvx2) ? avx2_lane_kernel() : nullptr;
    case 8:
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
  int lanes = widest_lane_kernel().lanes;
  while (lanes / 2 >= robots) lanes /= 2;
  return *lane_kernel(lanes);
}

}  // namespace engram
