// The renderers, by name.
#pragma once

#include <memory>

#include "core/image/renderer.h"
#include "core/math/instruction_set.h"

namespace engram {

// The renderer that the options name: "cpu" or "egl". Throws Error for another name, or a renderer
// that cannot work here.
std::unique_ptr<Renderer> make_renderer(const RenderScene& scene, const ImageSourceOptions& options,
                                        int workers);

// Makes the ray caster on that instruction set. All of them draw the same: for checks.
std::unique_ptr<Renderer> make_renderer_on(InstructionSet set, const RenderScene& scene,
                                           const ImageSourceOptions& options, int workers);

}  // namespace engram
