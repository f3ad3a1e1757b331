// Options of the ray caster.
#pragma once

#include "core/math/instruction_set.h"

namespace engram {

struct CpuRendererOptions {
  // Light directions traced per shadow-casting light: 0 is no shadows, 1 hard ones, more are soft.
  int shadow_rays = 0;
  float shadow_softness = 0.05F;  // half angle of the light's cone, rad; with more than one ray
  bool antialias = false;         // 2x2 samples a pixel, for colours
  InstructionSet instruction_set = InstructionSet::kAuto;
  int max_width = 2048;  // of any image, pixels
  int max_height = 2048;
};

}  // namespace engram
