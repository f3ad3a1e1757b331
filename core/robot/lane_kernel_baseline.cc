// Kernels for every processor: two lanes, and one for comparisons; and the choice of a kernel.
#include "core/robot/lane_kernel_body.h"
#include "core/robot/lane_kernels.h"

namespace engram {
namespace {

constexpr LaneKernel kSingle = make_lane_kernel<double>("one lane");
#if defined(__SSE2__)
constexpr LaneKernel kPair = make_lane_kernel<Lanes2>("sse2");
#else
constexpr LaneKernel kPair = make_lane_kernel<Lanes2>("two lanes");
#endif

#if defined(__x86_64__)
bool has_avx2() { return __builtin_cpu_supports("avx2") != 0; }
bool has_avx512() {
  return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0;
}
#else
bool has_avx2() { return false; }
bool has_avx512() { return false; }
#endif

}  // namespace

const LaneKernel* lane_kernel(int lanes) {
  switch (lanes) {
    case 1:
      return &kSingle;
    case 2:
      return &kPair;
    case 4:
      return has_avx2() ? avx2_lane_kernel() : nullptr;
    case 8:
      return has_avx512() ? avx512_lane_kernel() : nullptr;
    default:
      return nullptr;
  }
}

const LaneKernel& widest_lane_kernel() {
  int lanes = kMostLanes;
  while (lane_kernel(lanes) == nullptr) lanes /= 2;
  return *lane_kernel(lanes);
}

}  // namespace engram
