// The ray caster's inner loops for every machine.
#include "render/cpu_cells_body.h"
#include "render/cpu_eights_body.h"
#include "render/cpu_shade_body.h"
#include "render/cpu_store_body.h"
#include "render/cpu_tile_body.h"
#include "render/cpu_trace_body.h"

namespace engram::cpu {

const Kernel* baseline_kernel() {
  static constexpr Kernel kKernel = {
      &trace,        &shade,          &store_pairs,       &draw_tiles,          &store_both,
      &store_depths, &store_segments, &store_both_depths, &store_both_segments, &kEights};
  return &kKernel;
}

}  // namespace engram::cpu
