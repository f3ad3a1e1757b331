// Options of the OpenGL renderer.
#pragma once

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

}  // namespace engram
