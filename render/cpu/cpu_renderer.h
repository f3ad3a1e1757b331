// The ray caster: images from the processor alone, the same on every machine.
#pragma once

#include <memory>
#include <string>

#include "core/image/renderer.h"
#include "core/math/instruction_set.h"
#include "render/cpu/cpu_options.h"

namespace engram {

// True if this machine and this build of the library can run it. kAuto always can.
bool is_supported(InstructionSet set);

// Makes the ray caster. Geoms with alpha 0 are hidden, all others opaque. Surfaces have one side: a
// geom that a ray enters before the near plane is not seen, so a camera inside a geom looks out of
// it. Colour is rgb * (ambient + emission + sum of Lambert terms), clamped to 1. Depth and
// segmentation are those of pixel centres. Wood and grid patterns show on planes and boxes, wood
// with its grain along the longer side; other shapes are plain.
//
// render() does not touch images larger than the options allow, nor those of unknown cameras.
//
// Throws Error if the scene is inconsistent, an option is out of range, or the instruction set is
// missing here.
std::unique_ptr<Renderer> make_cpu_renderer(const RenderScene& scene,
                                            const CpuRendererOptions& options, int workers);

}  // namespace engram
