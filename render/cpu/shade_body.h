// Kernel, second half: each pixel's colour. Included by cpu_kernel_*.cc only.
#pragma once

#include "core/math/simd.h"
#include "render/cpu/frame_data.h"
#include "render/cpu/shadow_body.h"

namespace engram::cpu {
namespace {

using namespace simd;

// Pixels of a vector: rays, depths (1 / w) and how much of each light arrives.
struct Pixels {
  Float u, depth;
  float v;
  int x, y;               // of the first one
  const Float* arriving;  // part of each light; null: all of them in full
};

struct Color {
  Float r, g, b;  // 0..255
};

ENGRAM_INLINE Float evaluate(const Form& f, const Pixels& p) {
  return (f.a * p.u + (f.b * p.v + f.c)) * p.depth + f.d;
}

ENGRAM_INLINE Int pack(const Color& color) {
  // What is not a number counts as 0.
  const auto level = [](Float value) {
    return round(min(max(value, broadcast(0.0F)), broadcast(255.0F)));
  };
  return level(color.r) | (level(color.g) << 8) | (level(color.b) << 16);
}

// Ambient light, emission and the lights' light.
ENGRAM_INLINE Color light_surface(const FrameData& frame, const Surface& s, const Pixels& p) {
  Color color = {broadcast(s.constant[0]), broadcast(s.constant[1]), broadcast(s.constant[2])};
  if (s.lighting == Lighting::kConstant) return color;
  Float scale = broadcast(1.0F);
  if (s.lighting == Lighting::kEllipsoid) {
    const Float x = evaluate(s.axes[0], p);
    const Float y = evaluate(s.axes[1], p);
    const Float z = evaluate(s.axes[2], p);
    scale = 1.0F / sqrt(max(x * x + y * y + z * z, broadcast(1e-30F)));
  }
  for (int i = 0; i < frame.light_count; ++i) {
    Float amount = max(evaluate(s.toward[i], p) * scale, Float{});
    if (p.arriving != nullptr) amount = amount * p.arriving[i];
    color.r += amount * s.light[i][0];
    color.g += amount * s.light[i][1];
    color.b += amount * s.light[i][2];
  }
  return color;
}

// Change of a pattern's coordinates from pixel to pixel, at the middle of the pixels' block.
struct PixelFootprint {
  float along, across;
};

ENGRAM_INLINE float larger(float a, float b) { return a > b ? a : b; }

ENGRAM_INLINE float footprint_of(const float (&spread)[3], float u, float v) {
  return larger(__builtin_fabsf(spread[0] * v + spread[1]),
                __builtin_fabsf(spread[2] - spread[0] * u));
}

ENGRAM_INLINE PixelFootprint measure(const FrameData& frame, const Surface& s, const Pixels& p) {
  const float u = frame.u[(p.x & -kBlock) + kBlock / 2];
  const float w = larger(s.plane.a * u + (s.plane.b * p.v + s.plane.c), frame.far_w);
  const float scale = frame.pixel / (w * w);
  return {footprint_of(s.spread[0], u, p.v) * scale, footprint_of(s.spread[1], u, p.v) * scale};
}

// Texels per metre of the finest level.
constexpr float kTexels[2] = {WoodTexture::kAlong / WoodTexture::kAlongLength,
                              WoodTexture::kAcross / WoodTexture::kAcrossLength};
constexpr int kFloatBias = 127;

// A level of the wood's texture as a surface shows it. Cells are whole numbers below scale times
// the surface's forms, give or take one unit in the last place.
struct WoodLevel {
  float a[2], scale[2], d[2];
  int mask[2];
  int shift;
  const std::uint8_t* texels;

  ENGRAM_INLINE WoodLevel(const FrameData& frame, const Surface& s, int level) {
    const float shrink = __builtin_bit_cast(float, (kFloatBias - level) << 23);
    for (int i = 0; i < 2; ++i) {
      scale[i] = kTexels[i] * shrink;
      a[i] = s.axes[i].a * scale[i];
      d[i] = s.axes[i].d * scale[i] - 0.5F;
    }
    mask[0] = (WoodTexture::kAlong >> level) - 1;
    mask[1] = (WoodTexture::kAcross >> level) - 1;
    shift = WoodTexture::kAlongBits - level;
    texels = frame.wood.texels + frame.wood.offset[level];
  }
  // Along or across, for the forms' part that changes with the depth.
  ENGRAM_INLINE Int cell(int i, Float place) const { return round(place + d[i]) & mask[i]; }
  ENGRAM_INLINE Float brightness(Int along, Int across) const {
    return to_float(gather_bytes(texels, (across << shift) + along));
  }
};

// The wood's brightness, 0..255, from the level whose texels are about as large as pixels.
ENGRAM_INLINE Float read_wood(const FrameData& frame, const Surface& s, const Pixels& p) {
  const PixelFootprint footprint = measure(frame, s, p);
  const float texels = larger(footprint.along * kTexels[0], footprint.across * kTexels[1]);
  // The level is the logarithm, read from the exponent's bits.
  int level = (__builtin_bit_cast(std::int32_t, texels) >> 23) - kFloatBias;
  level = level < 0 ? 0 : (level < WoodTexture::kLevels ? level : WoodTexture::kLevels - 1);
  const WoodLevel wood(frame, s, level);
  Int cell[2];
  for (int i = 0; i < 2; ++i) {
    const float row = (s.axes[i].b * p.v + s.axes[i].c) * wood.scale[i];
    cell[i] = wood.cell(i, (wood.a[i] * p.u + row) * p.depth);
  }
  return wood.brightness(cell[0], cell[1]);
}

// Gain in brightness of the plane at these rays.
ENGRAM_INLINE Float gloss_along(const Gloss& gloss, Float u, Float v) {
  constexpr float kRest = 1 - Gloss::kWidth;
  const Float nearness = 1.0F / sqrt(u * u + (v * v + 1.0F));  // 1 / length of the ray
  const float* n = gloss.normal;
  const Float leaving = (n[0] * u + (n[1] * v + n[2])) * nearness;
  Float factor = broadcast(1.0F);
  for (int k = 0; k < gloss.light_count; ++k) {
    const float* l = gloss.light[k];
    const Float toward = (l[0] * u + (l[1] * v + l[2])) * nearness;
    const Float sum = gloss.facing[k] - leaving;
    const Float square = sum * sum;
    const Float lobe =
        square * Gloss::kWidth / max(2.0F - 2.0F * toward - square * kRest, broadcast(1e-6F));
    factor += lobe * lobe * Gloss::kStrength;
  }
  return factor;
}

// Gloss at nodes, which are every kGlossStep-th pixel.
ENGRAM_INLINE Float gloss_at_nodes(const FrameData& frame, const Gloss& gloss, Float column,
                                   Float row) {
  const float spacing = frame.pixel * kGlossStep;
  return gloss_along(gloss, column * spacing + frame.u[0], frame.v[0] - row * frame.pixel);
}

// Gloss at a row of nodes.
void find_gloss(const FrameData& frame, const Gloss& gloss, int y, int width, float* nodes) {
  for (int i = 0; i * kGlossStep <= width; i += kFloats) {
    Float index;
    for (int lane = 0; lane < kFloats; ++lane) index[lane] = static_cast<float>(i + lane);
    store(nodes + i, gloss_at_nodes(frame, gloss, index, broadcast(static_cast<float>(y))));
  }
}

// Between nodes: factors in a strip's first row, and what is added from row to row.
ENGRAM_INLINE void fill_in(const float* above, const float* below, float* first, float* step) {
  constexpr float kPart = 1.0F / kGlossStep;
  const float left = (below[0] - above[0]) * kPart;
  const float right = (below[1] - above[1]) * kPart;
  for (int k = 0; k < kGlossStep; ++k) {
    const float part = static_cast<float>(k) * kPart;
    first[k] = above[0] + (above[1] - above[0]) * part;
    step[k] = left + (right - left) * part;
  }
}

// For the strip of rows that `y` begins. `known`: the nodes below the last strip are those above
// this one.
void prepare_strip(const FrameData& frame, Gloss gloss, int y, int width, bool known) {
  const int strip = y / kGlossStep;
  float* above = gloss.nodes[strip & 1];
  float* below = gloss.nodes[(strip + 1) & 1];
  if (!known) find_gloss(frame, gloss, y, width, above);
  find_gloss(frame, gloss, y + kGlossStep, width, below);
  for (int i = 0; i * kGlossStep < width; ++i) {
    fill_in(above + i, below + i, gloss.first + i * kGlossStep, gloss.step + i * kGlossStep);
  }
}

ENGRAM_INLINE Float gloss_at(const FrameData& frame, const Surface& s, const Pixels& p) {
  const Gloss& gloss = frame.glosses[s.gloss];
  const auto row = static_cast<float>(p.y & (kGlossStep - 1));
  return load(gloss.first + p.x) + load(gloss.step + p.x) * row;
}

// Colours are multiplied by slope * brightness + least: grain changes blue more than red.
struct Tint {
  float slope, least;
};
constexpr Tint tint(float slope) { return {slope, 1 - slope * WoodTexture::kMean}; }
constexpr Tint kWoodTint[3] = {tint(0.90F / 300), tint(1.00F / 300), tint(1.10F / 300)};

ENGRAM_INLINE Color wood(const FrameData& frame, const Surface& s, const Pixels& p, Color color) {
  const Float brightness = read_wood(frame, s, p);
  Float gloss = gloss_at(frame, s, p);
  if (p.arriving != nullptr && frame.light_count > 0) {
    Float arriving = p.arriving[0];
    for (int i = 1; i < frame.light_count; ++i) arriving += p.arriving[i];
    gloss = (gloss - 1.0F) * (arriving * (1.0F / static_cast<float>(frame.light_count))) + 1.0F;
  }
  color = {color.r * gloss, color.g * gloss, color.b * gloss};
  color.r = color.r * (brightness * kWoodTint[0].slope + kWoodTint[0].least);
  color.g = color.g * (brightness * kWoodTint[1].slope + kWoodTint[1].least);
  color.b = color.b * (brightness * kWoodTint[2].slope + kWoodTint[2].least);
  return color;
}

// Wood with the same light all over: the table top, the larger part of most images.
struct EvenWood {
  float slope[3], least[3];

  ENGRAM_INLINE explicit EvenWood(const Surface& s) {
    for (int i = 0; i < 3; ++i) {
      slope[i] = kWoodTint[i].slope * s.constant[i];
      least[i] = kWoodTint[i].least * s.constant[i];
    }
  }
  ENGRAM_INLINE Int color(Float brightness, Float gloss) const {
    Int channel[3];
    for (int i = 0; i < 3; ++i) {
      const Float value = brightness * slope[i] + broadcast(least[i]);
      channel[i] = round(min(value * gloss, broadcast(255.0F)));
    }
    return channel[0] | (channel[1] << 8) | (channel[2] << 16);
  }
};

ENGRAM_INLINE Int even_wood(const FrameData& frame, const Surface& s, const Pixels& p) {
  const EvenWood wood(s);
  return wood.color(read_wood(frame, s, p), gloss_at(frame, s, p));
}

// Brightness of lines one metre apart, which fade to both sides. They are not filtered: far away,
// pixels meet them now and then, which makes dots.
ENGRAM_INLINE Float lines(Float position) {
  constexpr float kHalfWidth = 0.0195F;
  const Float distance = abs(position - to_float(round(position)));
  return max(broadcast(1.0F) - distance * (1.0F / kHalfWidth), Float{});
}

// Grey floor.
ENGRAM_INLINE Color grid(const Surface& s, const Pixels& p, Color color) {
  constexpr float kOff = 0.009F;  // the lines' middles are not at whole metres
  const Float bright =
      max(lines(evaluate(s.axes[0], p) - kOff), lines(evaluate(s.axes[1], p) + kOff));
  const Float factor = bright * 0.46F + 1.0F;
  return {color.r * factor, color.g * factor, color.b * factor};
}

Int shade_surface(const FrameData& frame, const Surface& s, const Pixels& p) {
  if (s.lighting == Lighting::kConstant && s.pattern == Pattern::kWood) {
    return even_wood(frame, s, p);
  }
  Color color = light_surface(frame, s, p);
  if (s.pattern == Pattern::kWood) color = wood(frame, s, p, color);
  if (s.pattern == Pattern::kGrid) color = grid(s, p, color);
  return pack(color);
}

ENGRAM_INLINE Int shade_id(const FrameData& frame, std::int32_t id, const Pixels& p) {
  const std::uint32_t code = frame.codes[id];
  if ((code & kShaded) == 0) return broadcast(static_cast<std::int32_t>(code));
  return shade_surface(frame, frame.surfaces[id], p);
}

// Shades a vector of pixels: once for each surface among them. With shadows, `arriving` is where
// each light's part is found.
ENGRAM_INLINE void shade_vector(const FrameData& frame, const Band& band, std::ptrdiff_t at, int x,
                                int y, const Float* arriving) {
  const Int ids = load(band.id + at);
  const std::int32_t first = band.id[at];
  Mask same = equal(ids, broadcast(first));
  const std::uint32_t code = frame.codes[first];
  if (all(same) && (code & kShaded) == 0) {
    store(band.color + at, broadcast(static_cast<std::int32_t>(code)));
    return;
  }

  const Pixels pixels = {load(frame.u + x), 1.0F / load(band.w + at), frame.v[y], x, y, arriving};
  Int color = shade_id(frame, first, pixels);
  Mask done = same;
  while (!all(done)) {
    const int lane = __builtin_ctz(static_cast<unsigned>(~bits(done)));
    const std::int32_t id = band.id[at + lane];
    same = equal(ids, broadcast(id));
    color = select(same, shade_id(frame, id, pixels), color);
    done = done | same;
  }
  store(band.color + at, color);
}

// Shades the rows y0 <= y < y1 of a block of columns, with shadows.
void shade_block(const FrameData& frame, const Band& band, int x0, int y0, int y1) {
  ShadowTile tile;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x0 + kBlock; x += kFloats, tile.count += kFloats) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y - band.y0) * band.width + x;
      const Float depth = 1.0F / load(band.w + at);
      store(tile.x + tile.count, load(frame.u + x) * depth);
      store(tile.y + tile.count, frame.v[y] * depth);
      store(tile.z + tile.count, depth);
      store(tile.id + tile.count, load(band.id + at));
    }
  }
  find_shadows(frame, tile);
  int i = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x0 + kBlock; x += kFloats, i += kFloats) {
      Float arriving[kMaxLights];
      for (int k = 0; k < frame.light_count; ++k) arriving[k] = load(tile.lit[k] + i);
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y - band.y0) * band.width + x;
      shade_vector(frame, band, at, x, y, arriving);
    }
  }
}

void shade(const FrameData& frame, const Band& band) {
  // A strip of the glosses at a time.
  for (int y = band.y0; y < band.y1;) {
    const int strip_end = (y & -kGlossStep) + kGlossStep;
    const int end = strip_end < band.y1 ? strip_end : band.y1;
    for (int i = 0; i < frame.gloss_count; ++i) {
      prepare_strip(frame, frame.glosses[i], y & -kGlossStep, band.width, y != band.y0);
    }
    for (int x = 0; x < band.width && frame.shadows; x += kBlock) {
      shade_block(frame, band, x, y, end);
    }
    for (; y < end; ++y) {
      const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(y - band.y0) * band.width;
      for (int x = 0; x < band.width && !frame.shadows; x += kFloats) {
        shade_vector(frame, band, row + x, x, y, nullptr);
      }
    }
  }
}

}  // namespace
}  // namespace engram::cpu
