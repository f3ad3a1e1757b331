// All inner loops of the ray caster, for the instruction set that this file is compiled for.
// Included by kernel_*.cc only.
#pragma once

#include "render/cpu/depth_segmentation_body.h"
#include "render/cpu/geom_batch_body.h"
#include "render/cpu/shade_body.h"
#include "render/cpu/store_body.h"
#include "render/cpu/tile_body.h"
#include "render/cpu/trace_body.h"

namespace engram::cpu {
namespace {

constexpr Kernel kKernel = {
    &trace,        &shade,          &store_pairs,       &draw_tiles,          &store_both,
    &store_depths, &store_segments, &store_both_depths, &store_both_segments, &kSetupKernel};

}  // namespace
}  // namespace engram::cpu
