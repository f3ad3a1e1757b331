// Pictures drawn by OpenGL through EGL: human views, videos, and machines with a GPU.
#pragma once

#include <memory>

#include "core/image/renderer.h"

namespace engram {

struct EglRendererOptions {
  int samples = 1;                // per pixel, for colours: 1, 2, 4 or 8
  bool shadows = false;           // of lights that cast them
  int shadow_map_size = 2048;     // texels of either side
  float shadow_softness = 0.05F;  // half angle of the light's cone, rad; 0 is hard
  float tolerance = 0.1F;         // how far round outlines may be off, pixels
  int max_width = 2048;           // of any image, pixels
  int max_height = 2048;
};

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
