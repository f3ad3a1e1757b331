// Kernel: wood in a tile, row by row. Included by cpu_kernel_*.cc only.
#pragma once

#include "core/math/simd.h"
#include "render/cpu/frame_data.h"
#include "render/cpu/shade_body.h"
#include "render/cpu/tile_scan_body.h"

namespace engram::cpu {
namespace {

using namespace simd;

// The texture's level in each row of a tile, as read_wood() has it.
struct WoodRows {
  alignas(64) std::int32_t level[kBlock];

  ENGRAM_INLINE WoodRows(const FrameData& frame, const Surface& s, const float* v_of_rows,
                         const float* u_of_columns) {
    constexpr float kTop = WoodTexture::kLevels - 1;
    const float u = u_of_columns[kBlock / 2];
    const float au = s.plane.a * u;
    for (int i = 0; i < kBlock; i += kFloats) {
      const Float v = load(v_of_rows + i);
      const Float w = max(au + (s.plane.b * v + s.plane.c), broadcast(frame.far_w));
      const Float scale = frame.pixel / (w * w);
      Float footprint[2];
      for (int k = 0; k < 2; ++k) {
        const float(&spread)[3] = s.spread[k];
        footprint[k] = max(abs(spread[0] * v + spread[1]),
                           broadcast(__builtin_fabsf(spread[2] - spread[0] * u))) *
                       scale;
      }
      const Float texels = max(footprint[0] * kTexels[0], footprint[1] * kTexels[1]);
      const Float exponent = to_float((Int(texels) >> 23) - kFloatBias);
      store(level + i, truncate(clamp(exponent, 0.0F, kTop)));
    }
  }

  // The rows of a level.
  ENGRAM_INLINE std::uint32_t of(std::int32_t wanted) const {
    std::uint32_t rows = 0;
    for (int i = 0; i < kBlock; i += kFloats) {
      rows |= static_cast<std::uint32_t>(bits(equal(load(level + i), broadcast(wanted)))) << i;
    }
    return rows;
  }
};

// A tile's part of a gloss: of its two strips, the first row and what is added from row to row.
struct TileGloss {
  static_assert(kBlock == 2 * kGlossStep);
  alignas(64) float first[2][kBlock];
  alignas(64) float step[2][kBlock];

  // `x` and `y`: the tile's place in the image.
  ENGRAM_INLINE TileGloss(const FrameData& frame, const Gloss& gloss, int x, int y) {
    alignas(64) static constexpr float kColumn[16] = {0, 1, 2, 0, 1, 2, 0, 1, 2};
    alignas(64) static constexpr float kRow[16] = {0, 0, 0, 1, 1, 1, 2, 2, 2};
    constexpr int kNodes = 9;
    alignas(64) float nodes[16];
    const int first_column = x / kGlossStep;
    for (int i = 0; i < kNodes; i += kFloats) {
      const Float column = load(kColumn + i) + static_cast<float>(first_column);
      const Float row = load(kRow + i) * kGlossStep + static_cast<float>(y);
      store(nodes + i, gloss_at_nodes(frame, gloss, column, row));
    }
    for (int strip = 0; strip < 2; ++strip) {
      const float* above = nodes + 3 * strip;
      for (int half = 0; half < 2; ++half) {
        fill_in(above + half, above + 3 + half, first[strip] + half * kGlossStep,
                step[strip] + half * kGlossStep);
      }
    }
  }
};

// The part of each row in the place of its cells.
struct WoodPlace {
  alignas(64) float row[2][kBlock];

  ENGRAM_INLINE WoodPlace(const WoodLevel& level, const Surface& s, const float* v) {
    for (int k = 0; k < 2; ++k) {
      for (int i = 0; i < kBlock; i += kFloats) {
        store(row[k] + i, (load(v + i) * s.axes[k].b + s.axes[k].c) * level.scale[k]);
      }
    }
  }
};

// Colours some rows of the tile that begins at column x of a row of tiles: in all of their pixels,
// or in those that have the wood's code.
template <bool kAll>
void paint_wood(const Scan& s, const TileRow& row, int x, std::int32_t index, std::uint32_t rows) {
  const FrameData& frame = *s.frame;
  const Surface& surface = frame.surfaces[index];
  const Int code = broadcast(static_cast<std::int32_t>(kShaded) | index);
  const float* u_of_columns = s.u + x;
  const WoodRows levels(frame, surface, s.v, u_of_columns);
  const TileGloss gloss(frame, frame.glosses[surface.gloss], row.x + x, row.y);
  const EvenWood wood(surface);
  const Rows plane(surface.plane, s.v);
  while (rows != 0) {
    const int level_here = levels.level[__builtin_ctz(rows)];
    const std::uint32_t same = rows & levels.of(level_here);
    rows &= ~same;
    const WoodLevel level(frame, surface, level_here);
    const WoodPlace place(level, surface, s.v);
    for (int part = 0; part < kBlock; part += kFloats) {
      const Float u = load(u_of_columns + part);
      const Float plane_column = surface.plane.a * u;
      const Float cell_column[2] = {level.a[0] * u, level.a[1] * u};
      for (std::uint32_t left = same; left != 0; left &= left - 1) {
        const int y = __builtin_ctz(left);
        std::int32_t* at = s.code + y * s.pitch + x + part;
        Mask here = equal(code, code);
        if constexpr (!kAll) {
          here = equal(load(at), code);
          if (!any(here)) continue;
        }
        const Float depth = 1.0F / (plane_column + plane[y]);
        const Float brightness =
            level.brightness(level.cell(0, (cell_column[0] + place.row[0][y]) * depth),
                             level.cell(1, (cell_column[1] + place.row[1][y]) * depth));
        const int strip = y / kGlossStep;
        const Float factor = load(gloss.first[strip] + part) +
                             load(gloss.step[strip] + part) * static_cast<float>(y % kGlossStep);
        const Int color = wood.color(brightness, factor);
        if constexpr (kAll) {
          store(at, color);
        } else {
          store(at, select(here, color, load(at)));
        }
      }
    }
  }
}

}  // namespace
}  // namespace engram::cpu
