// The ray caster's inner loops for AVX-512; compiled with -mavx512f -mavx512bw -mavx512dq
// -mavx512vl.
#if defined(__AVX512F__) && defined(__AVX512BW__)

#include "render/cpu_cells_body.h"
#include "render/cpu_eights_body.h"
#include "render/cpu_shade_body.h"
#include "render/cpu_store_body.h"
#include "render/cpu_tile_body.h"
#include "render/cpu_trace_body.h"

namespace engram::cpu {

const Kernel* avx512_kernel() {
  static constexpr Kernel kKernel = {
      &trace,        &shade,          &store_pairs,       &draw_tiles,          &store_both,
      &store_depths, &store_segments, &store_both_depths, &store_both_segments, &kEights};
  return &kKernel;
}

}  // namespace engram::cpu

#else  // another processor or compiler

#include "render/cpu_frame.h"

namespace engram::cpu {

const Kernel* avx512_kernel() { return nullptr; }

}  // namespace engram::cpu

#endif
