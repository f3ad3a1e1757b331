// Kernel: colours of a row of tiles, without shadows: the pixels of trace() and shade(). Included
// by cpu_kernel_*.cc only.
#pragma once

#include "core/math/simd.h"
#include "render/cpu/frame_data.h"
#include "render/cpu/shade_body.h"
#include "render/cpu/tile_scan_body.h"
#include "render/cpu/tile_wood_body.h"

namespace engram::cpu {
namespace {

using namespace simd;

using Tiles = std::uint64_t;  // a bit for each tile of a row
static_assert(kPanelTiles == 64);

// Tiles first <= i < end.
ENGRAM_INLINE Tiles tile_range(int first, int end) {
  if (first >= end) return 0;
  return (~Tiles{0} >> (64 - (end - first))) << first;
}

ENGRAM_INLINE int first_tile(Tiles tiles) { return __builtin_ctzll(tiles); }

// Least and largest value of a bound of w in some tiles. Rounding is monotone, so corners have
// them.
struct WRange {
  Float low, high;

  ENGRAM_INLINE WRange(const Affine& f, Float left, Float right, float top, float bottom) {
    const Float a0 = f.a * left;
    const Float a1 = f.a * right;
    const Float b0 = broadcast(f.b * top + f.c);
    const Float b1 = broadcast(f.b * bottom + f.c);
    low = min(a0, a1) + min(b0, b1);
    high = max(a0, a1) + max(b0, b1);
  }
};

// One face fills each of these tiles, and nothing else shows in them but what is nearer.
struct Cover {
  const ScreenPrimitive* primitive;
  alignas(64) float low[kPanelTiles];  // of w
  alignas(64) std::int32_t face[kPanelTiles];
};

// Edges of the tiles of a row.
struct Edges {
  const float* left;
  const float* right;
  float top, bottom;
  int tiles;
};

// In which tiles a face of a body of six planes covers each ray.
ENGRAM_INLINE Tiles find_cover(const FrameData& frame, const Edges& edges, Cover& cover) {
  const ScreenPrimitive& p = *cover.primitive;
  Tiles covered = 0;
  for (int i = 0; i < edges.tiles; i += kFloats) {
    const Float left = load_unaligned(edges.left + i);
    const Float right = load_unaligned(edges.right + i);
    Float low = broadcast(-1.0F);
    Float high = broadcast(3e38F);
    Float exit = broadcast(-3e38F);
    Int face = Int{};
    for (int k = 0; k < 6; ++k) {
      const WRange range(p.planes[k], left, right, edges.top, edges.bottom);
      if (k >= p.front_count) {
        exit = max(exit, range.high);
        continue;
      }
      const Mask first = less(range.high, high);
      face = select(first, broadcast(k), face);
      low = select(first, range.low, low);
      high = min(range.high, high);
    }
    Mask whole = at_most(exit, low) & at_most(high, broadcast(frame.near_w)) &
                 less(broadcast(frame.far_w), low);
    for (int k = 0; k < p.front_count; ++k) {
      const WRange range(p.planes[k], left, right, edges.top, edges.bottom);
      whole = whole & (less(high, range.low) | equal(face, broadcast(k)));
    }
    store(cover.low + i, low);
    store(cover.face + i, face);
    covered |= static_cast<Tiles>(static_cast<unsigned>(bits(whole))) << i;
  }
  return covered & tile_range(0, edges.tiles);
}

// In which tiles the cover hides a plane.
ENGRAM_INLINE Tiles hidden_by(const Cover& cover, const ScreenPrimitive& plane,
                              const Edges& edges) {
  Tiles hidden = 0;
  for (int i = 0; i < edges.tiles; i += kFloats) {
    const WRange range(plane.planes[0], load_unaligned(edges.left + i),
                       load_unaligned(edges.right + i), edges.top, edges.bottom);
    const Mask behind = less(range.high, load(cover.low + i));
    hidden |= static_cast<Tiles>(static_cast<unsigned>(bits(behind))) << i;
  }
  return hidden;
}

// Finds the primitives that reach into a row of tiles.
void find_candidates(const FrameData& frame, TileRow& row) {
  row.candidate_count = 0;
  for (int block = 0; block < frame.primitive_count; block += kFloats) {
    const Mask above_end = negative(load(frame.tops + block) - (row.y + row.rows));
    const Mask below_begin = negative(row.y - load(frame.bottoms + block));
    for (int left = bits(above_end & below_begin); left != 0; left &= left - 1) {
      const int i = block + __builtin_ctz(static_cast<unsigned>(left));
      const Rect& rect = frame.rects[i];
      const int first = rect.x0 > row.x ? (rect.x0 - row.x) / kBlock : 0;
      const int end = (rect.x1 - row.x + kBlock - 1) / kBlock;
      const Tiles tiles = tile_range(first, end < row.tiles ? end : row.tiles);
      row.candidates[row.candidate_count] = {frame.primitives[i], tiles};
      row.candidate_count += tiles != 0 ? 1 : 0;
    }
  }
}

// The tiles that lie in a rectangle as far as they lie in the image.
ENGRAM_INLINE Tiles tiles_within(const FrameData& frame, const Rect& rect, const TileRow& row) {
  if (rect.y0 > row.y || rect.y1 < row.y + row.rows) return 0;
  const int first = rect.x0 > row.x ? (rect.x0 - row.x + kBlock - 1) / kBlock : 0;
  const int end = rect.x1 >= frame.width ? row.tiles : (rect.x1 - row.x) / kBlock;
  return tile_range(first, end < row.tiles ? end : row.tiles);
}

ENGRAM_INLINE bool is_even_wood(const Surface& s) {
  return s.lighting == Lighting::kConstant && s.pattern == Pattern::kWood;
}

// Fills a tile with the face of a body, or with the background if `face` is -1.
ENGRAM_INLINE void fill_tile(const Scan& s, const TileRow& row, int tile, const ScreenPrimitive* p,
                             int face) {
  const int x = tile * kBlock;
  const std::uint32_t code = s.frame->codes[p == nullptr ? 0 : p->surface + face];
  const Affine plane = p == nullptr ? Affine{0, 0, s.frame->far_w} : p->planes[face];
  const Rows rows(plane, s.v);
  for (int part = 0; part < kBlock; part += kFloats) {
    const Float column = plane.a * load(s.u + x + part);
    for (int y = 0; y < row.rows; ++y) {
      store(s.w + y * s.pitch + x + part, column + rows[y]);
      store(s.code + y * s.pitch + x + part, broadcast(static_cast<std::int32_t>(code)));
    }
  }
}

// Fills the tiles that one face covers. What comes before it in the order of drawing would win
// where both are equally near: such tiles are left alone. Returns those that were filled; `shaded`
// gets those that need shading.
Tiles fill_covered(const Scan& s, TileRow& row, const Edges& edges, int index, Tiles candidates,
                   Tiles& shaded) {
  TileCandidate& body = row.candidates[index];
  Cover cover;
  cover.primitive = body.primitive;
  Tiles covered = candidates & find_cover(*s.frame, edges, cover);
  Tiles others = 0;
  for (int i = 0; i < row.candidate_count && covered != 0; ++i) {
    if (i == index) continue;
    Tiles here = row.candidates[i].tiles & covered;
    const ScreenPrimitive& other = *row.candidates[i].primitive;
    if (here != 0 && other.kind == PrimitiveKind::kPlane) here &= ~hidden_by(cover, other, edges);
    if (i < index) {
      covered &= ~here;
    } else {
      others |= here;
    }
  }
  for (int i = 0; i < row.candidate_count && covered != 0; ++i) {
    const ScreenPrimitive& other = *row.candidates[i].primitive;
    if (other.kind == PrimitiveKind::kPlane && (row.candidates[i].tiles & covered) != 0) {
      row.candidates[i].tiles &= ~(covered & hidden_by(cover, other, edges));
    }
  }
  body.tiles &= ~covered;
  for (Tiles left = covered; left != 0; left &= left - 1) {
    const int tile = first_tile(left);
    const int surface = body.primitive->surface + cover.face[tile];
    const bool alone = (others >> tile & 1) == 0;
    const bool patterned = (s.frame->codes[surface] & kShaded) != 0;
    if (alone && patterned && is_even_wood(s.frame->surfaces[surface])) {
      if (row.keeps_depth) fill_tile(s, row, tile, body.primitive, cover.face[tile]);
      paint_wood<true>(s, row, tile * kBlock, surface, (1U << row.rows) - 1);
      continue;
    }
    fill_tile(s, row, tile, body.primitive, cover.face[tile]);
    if (patterned) shaded |= Tiles{1} << tile;
  }
  return covered;
}

// Fills tiles before primitives are drawn into them.
void prepare_tiles(const Scan& s, TileRow& row, Tiles& shaded) {
  const FrameData& frame = *s.frame;
  const Edges edges = {frame.left + row.x / kBlock, frame.right + row.x / kBlock, s.v[0],
                       s.v[row.rows - 1], row.tiles};
  Tiles empty = tile_range(0, row.tiles);
  for (int i = 0; i < row.candidate_count; ++i) {
    const ScreenPrimitive& p = *row.candidates[i].primitive;
    if (p.kind != PrimitiveKind::kConvex || p.front_count + p.back_count != 6) continue;
    const Tiles candidates = empty & row.candidates[i].tiles & tiles_within(frame, p.rect, row);
    if (candidates != 0) empty &= ~fill_covered(s, row, edges, i, candidates, shaded);
  }
  for (; empty != 0; empty &= empty - 1) fill_tile(s, row, first_tile(empty), nullptr, 0);
}

// Copies tiles from the backdrop. Those into which nothing reaches stay in it.
void copy_tiles(const Scan& s, const Backdrop& backdrop, TileRow& row) {
  Tiles touched = 0;
  for (int i = 0; i < row.candidate_count; ++i) touched |= row.candidates[i].tiles;
  for (int tile = 0; tile < row.tiles; ++tile) {
    const int x = tile * kBlock;
    const std::ptrdiff_t from = static_cast<std::ptrdiff_t>(row.y) * backdrop.stride + row.x + x;
    if ((touched >> tile & 1) == 0) {
      row.source[tile] = backdrop.color + from;
      row.w_source[tile] = backdrop.w + from;
      row.stride[tile] = backdrop.stride;
      continue;
    }
    const float* w = backdrop.w + from;
    const auto* color = reinterpret_cast<const std::int32_t*>(backdrop.color) + from;
    for (int y = 0; y < row.rows; ++y, w += backdrop.stride, color += backdrop.stride) {
      for (int part = 0; part < kBlock; part += kFloats) {
        store(s.w + y * s.pitch + x + part, load_unaligned(w + part));
        store(s.code + y * s.pitch + x + part, load_unaligned(color + part));
      }
    }
  }
}

// Draws a primitive into its tiles, run by run.
ENGRAM_INLINE void draw_candidate(const Scan& s, const TileRow& row,
                                  const TileCandidate& candidates, Tiles& shaded) {
  const ScreenPrimitive& p = *candidates.primitive;
  const Rect& rect = p.rect;
  Span span;
  span.y0 = rect.y0 > row.y ? rect.y0 - row.y : 0;
  span.y1 = rect.y1 < row.y + row.rows ? rect.y1 - row.y : row.rows;
  for (Tiles left = candidates.tiles; left != 0;) {
    const int begin = first_tile(left);
    const Tiles beyond = ~(left >> begin);
    const int end = beyond == 0 ? kPanelTiles : begin + first_tile(beyond);
    left &= ~tile_range(begin, end);
    span.x0 = begin * kBlock > rect.x0 - row.x ? begin * kBlock : rect.x0 - row.x;
    span.x1 = end * kBlock < rect.x1 - row.x ? end * kBlock : rect.x1 - row.x;
    scan_primitive(s, p, span);
  }
  if (p.shaded && s.frame->shades) shaded |= candidates.tiles;
}

// Converts a tile's codes to colours.
void shade_tile(const Scan& s, const TileRow& row, int tile) {
  constexpr auto kIndex = static_cast<std::int32_t>(~kShaded);
  const FrameData& frame = *s.frame;
  const int x = tile * kBlock;
  std::int32_t wood = 0;        // a code
  std::uint32_t wood_rows = 0;  // where that is
  bool again = false;           // there is another wood
  for (int y = 0; y < row.rows; ++y) {
    for (int part = 0; part < kBlock; part += kFloats) {
      const std::ptrdiff_t place = y * s.pitch + x + part;
      const Int codes = load(s.code + place);
      const Mask wooden = equal(codes, broadcast(wood));  // not if `wood` is 0: then it is a colour
      Mask left = negative(codes);
      if (any(left & wooden)) wood_rows |= 1U << y;
      left = without(left, wooden);
      if (!any(left)) continue;
      Int color = codes;
      const Pixels pixels = {load(s.u + x + part),
                             1.0F / load(s.w + place),
                             s.v[y],
                             row.x + x + part,
                             row.y + y,
                             nullptr};
      do {
        const int lane = __builtin_ctz(static_cast<unsigned>(bits(left)));
        const std::int32_t code = s.code[place + lane];
        const Mask same = equal(codes, broadcast(code));
        left = without(left, same);
        const Surface& surface = frame.surfaces[code & kIndex];
        if (surface.lighting == Lighting::kLinear && surface.pattern == Pattern::kPlain) {
          color = select(same, pack(light_surface(frame, surface, pixels)), color);
        } else if (!is_even_wood(surface)) {
          color = select(same, shade_surface(frame, surface, pixels), color);
        } else if (wood == 0) {
          wood = code;
          wood_rows |= 1U << y;
        } else {
          again = true;
        }
      } while (any(left));
      store(s.code + place, color);
    }
  }
  if (wood_rows != 0) paint_wood<false>(s, row, x, wood & kIndex, wood_rows);
  if (again) shade_tile(s, row, tile);
}

void draw_tiles(const FrameData& frame, const Backdrop* backdrop, TileRow& row) {
  const Scan s = {&frame, frame.u + row.x, frame.v + row.y, row.w, row.code, row.pitch};
  for (int tile = 0; tile < row.tiles; ++tile) {
    row.source[tile] = reinterpret_cast<const std::uint32_t*>(row.code) + tile * kBlock;
    row.w_source[tile] = row.w + tile * kBlock;
    row.stride[tile] = row.pitch;
  }
  find_candidates(frame, row);
  Tiles shaded = 0;
  if (backdrop != nullptr) {
    copy_tiles(s, *backdrop, row);
  } else {
    prepare_tiles(s, row, shaded);
  }
  for (int i = 0; i < row.candidate_count; ++i) draw_candidate(s, row, row.candidates[i], shaded);
  for (; shaded != 0; shaded &= shaded - 1) shade_tile(s, row, first_tile(shaded));
}

}  // namespace
}  // namespace engram::cpu
