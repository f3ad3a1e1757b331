// Programs of the OpenGL renderer.
#pragma once

#include "render/egl/gl_functions.h"

namespace engram::gl {

inline constexpr int kMaxLights = 8;
inline constexpr int kShadowTaps = 16;

// Attributes of vertices and instances; the shaders know them by these numbers.
enum Attribute : GLuint { kPosition, kNormal, kRowX, kRowY, kRowZ, kScale, kColor, kKind };

// Bits of an instance's second kind: what its surface shows.
inline constexpr int kPatternMask = 3;  // a RenderPattern
inline constexpr int kPlaneBit = 4;     // a plane: patterns along x ...
inline constexpr int kSwapBit = 8;      // ... or along y
inline constexpr int kTurnBit = 16;     // along and across change places

// Texture units.
inline constexpr int kWoodUnit = 0;
inline constexpr int kShadowUnit = 1;       // compares depths
inline constexpr int kShadowDepthUnit = 2;  // the same map, giving depths

struct ColorFeatures {
  int lights = 0;
  bool shadows = false;
  bool patterns = false;
  bool smooth = false;  // patterns are averaged over four places in each pixel
};

// These throw Error (kUnavailable) with the compiler's message.
GLuint make_color_program(const Gl& gl, const ColorFeatures& features);
GLuint make_data_program(const Gl& gl);   // depth and segment
GLuint make_depth_program(const Gl& gl);  // nothing but the depth buffer

}  // namespace engram::gl
