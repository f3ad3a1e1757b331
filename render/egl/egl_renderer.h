// Images drawn by OpenGL through EGL: human views, videos, and machines with a GPU.
#pragma once

#include <memory>

#include "core/image/renderer.h"
#include "render/egl/egl_options.h"

namespace engram {

// Draws what the CPU renderer draws, by the same formulas: surfaces have one side, geoms with alpha
// 0 are hidden and all others opaque. Depth and segmentation are those of pixel centres. Round
// shapes are polygons as fine as `tolerance` asks. Planes cast no shadows.
//
// Each worker has a context. It is current within render() only, so render() may run on any thread.
// The first image of each size makes the driver allocate. Images larger than the options allow, or
// of unknown cameras, are not touched; none is if the device is lost.
//
// Throws Error: kInvalidArgument if scene or options are inconsistent, kUnavailable if there is no
// EGL or it cannot do what was asked.
std::unique_ptr<Renderer> make_egl_renderer(const RenderScene& scene,
                                            const EglRendererOptions& options, int workers);

}  // namespace engram
