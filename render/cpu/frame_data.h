// Input of the ray caster's kernels: one camera's view of one environment.
//
// Rays are d = (u, v, 1) in the camera's axes right, up, forward. Hits are stored as w = 1 / depth,
// because w is affine in (u, v) on every plane. Plain data only: this header is compiled for
// several instruction sets.
#pragma once

#include <cstddef>
#include <cstdint>

namespace engram::cpu {

inline constexpr int kBlock = 16;       // pixels; rows are padded to whole blocks
inline constexpr int kPanelTiles = 64;  // tiles are kBlock x kBlock pixels
inline constexpr int kMaxLights = 8;
inline constexpr int kMaxRays = 64;   // of all lights together
inline constexpr int kGlossStep = 8;  // pixels from node to node of a gloss; divides kBlock

constexpr int padded(int size) { return (size + kBlock - 1) / kBlock * kBlock; }

// a u + b v + c
struct Affine {
  float a, b, c;
};

// A quadric's entry: w = b + sqrt(disc), both polynomials in u - u0 and v - v0.
struct Conic {
  float u0, v0;
  float bu, bv, b1;
  float uu, uv, vv, u, v, one;
};

// Pixels x0 <= x < x1, y0 <= y < y1.
struct Rect {
  int x0, x1, y0, y1;
};

enum class PrimitiveKind : std::uint8_t { kConvex, kBall, kCapsule, kCylinder, kPlane };

// The volume with which a primitive blocks light: points p with (p - center)' form (p - center)
// <= 1; for capsules and cylinders, the part of it between two planes. Convex bodies use their
// planes instead.
struct Occluder {
  float center[3];
  float radius;   // of the ball around it
  float form[6];  // xx, yy, zz, xy, xz, yz
  float axis[3];  // unit; capsules and cylinders
  float half_length;
  float end;  // 1 / radius^2 of a capsule's ends
};

struct ScreenPrimitive {
  PrimitiveKind kind;
  bool camera_within_side;  // cylinders: the camera is inside the infinite cylinder
  bool shaded;              // the colour of a surface is not the same all over
  Rect rect;
  int surface;  // of its first face
  int surface_count;
  int front_count;  // planes that the camera is in front of: upper bounds of w
  int back_count;   // the others, which follow: lower bounds of w
  const Affine* planes;
  Conic conic[3];   // ball; capsule: side and two ends; cylinder: side
  Affine local[2];  // capsule: coordinate along the axis; plane: x, y
  float offset[2];  // the same of the camera
  float limit[2];   // their largest magnitude
  Occluder occluder;
};

enum class Lighting : std::uint8_t {
  kConstant,   // one colour all over
  kLinear,     // the normal's part towards each light is a form
  kEllipsoid,  // the same, but the normal must be normalised
};

enum class Pattern : std::uint8_t { kPlain, kWood, kGrid };

// (a u + b v + c) / w + d: an affine function of the visible point
struct Form {
  float a, b, c, d;
};

// A surface's code is the pixel if that is the same all over; else this bit, and its index.
inline constexpr std::uint32_t kShaded = 0x80000000U;

// Only where the code is no pixel.
struct Surface {
  Lighting lighting;
  Pattern pattern;
  int gloss;                   // one of the frame's, or -1
  float constant[3];           // kConstant: lit colour; else what is added to the lights'; 0..255
  float light[kMaxLights][3];  // colour of each light times the surface's
  Form toward[kMaxLights];     // part of the normal towards the light
  Form axes[3];                // ellipsoid: normal; patterns: coordinates along, across
  Affine plane;                // patterns: w
  // Patterns: how fast a coordinate changes. (a u + b v + c) / w has the derivatives
  // (spread[0] v + spread[1]) / w^2 by u and (spread[2] - spread[0] u) / w^2 by v. In each of these
  // numerators the variable of the derivative cancels out.
  float spread[2][3];
};

// Gain in brightness of a plane that mirrors the lights. Each light adds up to kStrength, most
// where the normal is halfway between eye and light, and less the farther off that is.
struct Gloss {
  static constexpr float kStrength = 0.548F;
  static constexpr float kWidth = 0.134F;  // half of it is left 0.46 rad from the mirror image
  float normal[3];                         // camera axes, like the rest
  int light_count;                         // those that the plane faces
  float light[kMaxLights][3];
  float facing[kMaxLights];  // normal . light
  // Working memory of kernels, a padded row each: factors in the first row of a strip of kGlossStep
  // rows, and what is added from row to row; then nodes above and below the strip.
  float* first;
  float* step;
  float* nodes[2];
};

// An image of the wood's brightness, 0..255, in ever coarser levels.
struct WoodTexture {
  static constexpr int kLevels = 8;
  static constexpr int kAlongBits = 10;
  static constexpr int kAlong = 1 << kAlongBits;  // texels of level 0; powers of two
  static constexpr int kAcross = 512;
  static constexpr float kAlongLength = 2.418F;  // m, then it repeats: the table's size
  static constexpr float kAcrossLength = 1.209F;
  static constexpr int kMean = 128;  // of all levels: the colour as it is
  const std::uint8_t* texels;        // level after level, row after row
  int offset[kLevels];
};

// Balls around primitives, in their order: what may cast shadows. Padded with balls that no ray
// meets.
struct Casters {
  const float* x;
  const float* y;
  const float* z;
  const float* radius;
};

struct FrameData {
  const float* u;      // of each column, padded to whole blocks, and a block more
  const float* v;      // of each row, padded to whole blocks
  const float* left;   // u of each block's first column, padded to whole blocks of blocks
  const float* right;  // and of its last
  int width, height;
  float pixel;  // size of a pixel in u and v
  float near_w, far_w;
  const ScreenPrimitive* const* primitives;  // roughly from near to far
  const Rect* rects;                         // theirs
  const std::int32_t* tops;                  // y0 and y1 of these, and then empty ranges up to a
  const std::int32_t* bottoms;               // whole block
  int primitive_count;
  const Surface* surfaces;     // surface 0 is the background
  const std::uint32_t* codes;  // of the surfaces
  const std::uint32_t* segments;
  bool shades;  // some of the codes may need shading
  const Gloss* glosses;
  int gloss_count;
  int light_count;
  // Shadows: rays towards each light, in camera axes; `ray_begin` has light_count + 1 entries.
  bool shadows;
  int ray_begin[kMaxLights + 1];
  float ray[kMaxRays][3];
  Casters casters;
  WoodTexture wood;
};

// Some rows of an image, with working memory for their pixels.
struct Band {
  int y0, y1;
  int width;             // padded
  float* w;              // 1 / depth
  std::int32_t* id;      // surface
  std::uint32_t* color;  // 0x00bbggrr
};

// Primitives are drawn from near to far, so that few pixels are drawn twice; at equal depths in the
// geoms' order.
struct Rank {
  float depth;
  int geom;
  int primitive;
};

// Image of everything that never moves, for one camera.
struct Backdrop {
  const float* w;
  const std::uint32_t* color;
  int stride;
  Rank last;  // of what it shows
};

// A primitive that reaches into a row of tiles, and those where it may show: a bit each.
struct TileCandidate {
  const ScreenPrimitive* primitive;
  std::uint64_t tiles;
};

// Part of a row of tiles of one image, and working memory for it.
struct TileRow {
  int x, y;          // of its first pixel
  int tiles, rows;   // at most kPanelTiles, kBlock
  bool keeps_depth;  // w is wanted, too
  // Memory for kBlock rows of `pitch` pixels: a block more than the widest row of tiles, as vectors
  // may reach beyond. Every row begins on a vector's boundary.
  int pitch;
  float* w;
  std::int32_t* code;         // codes, then colours
  TileCandidate* candidates;  // as many as the frame has primitives
  int candidate_count;
  // The colours of each tile and, if kept, its depths: where they begin, and from row to row.
  const std::uint32_t* source[kPanelTiles];
  const float* w_source[kPanelTiles];
  int stride[kPanelTiles];
};

// Red, green, blue; the processor is little endian.
static inline void store_color(std::uint32_t color, std::uint8_t* out) {
  const auto red_green = static_cast<std::uint16_t>(color);
  __builtin_memcpy(out, &red_green, 2);
  out[2] = static_cast<std::uint8_t>(color >> 16);
}

struct SetupKernel;  // geom_batch.h

// One build of the inner loops.
struct Kernel {
  void (*trace)(const FrameData& frame, const Band& band);  // fills w and id
  void (*shade)(const FrameData& frame, const Band& band);  // fills color
  // Writes three bytes for each colour, six bytes apart.
  void (*store_pairs)(const std::uint32_t* colors, int count, std::uint8_t* out);
  // Draws the pixels of trace and shade, without shadows. The backdrop may be null.
  void (*draw_tiles)(const FrameData& frame, const Backdrop* backdrop, TileRow& row);
  // Writes a row of pixels of two cameras' tiles, `y` rows below the tiles' first one.
  void (*store_both)(const TileRow& first, const TileRow& second, int y, int count,
                     std::uint8_t* out);
  // Rows of depths as observations have them, or of segments, where the frame's codes are those: of
  // one camera, a value every `step`, or of two, side by side.
  void (*store_depths)(const TileRow& row, float far_w, int y, int count, std::ptrdiff_t step,
                       std::int16_t* out);
  void (*store_segments)(const TileRow& row, int y, int count, std::ptrdiff_t step,
                         std::int16_t* out);
  void (*store_both_depths)(const TileRow& first, const TileRow& second, const float* far_w, int y,
                            int count, std::int16_t* out);
  void (*store_both_segments)(const TileRow& first, const TileRow& second, int y, int count,
                              std::int16_t* out);
  const SetupKernel* setup;
};

// Null where this build of the library lacks them.
const Kernel* baseline_kernel();
const Kernel* avx2_kernel();
const Kernel* avx512_kernel();

}  // namespace engram::cpu
