// Kernel: draws primitives into a row of tiles. Each pixel gets the values that trace() finds.
// Included by cpu_kernel_*.cc only.
#pragma once

#include "core/math/simd.h"
#include "render/cpu/frame_data.h"

namespace engram::cpu {
namespace {

using namespace simd;

// Pixels of a row of tiles, counted from its first one.
struct Span {
  int x0, x1, y0, y1;
};

// A row of tiles while it is drawn.
struct Scan {
  const FrameData* frame;
  const float* u;  // of the row's first column
  const float* v;  // of its rows
  float* w;
  std::int32_t* code;
  std::ptrdiff_t pitch;  // from row to row
};

// b v + c of a tile's rows.
struct Rows {
  alignas(64) float value[kBlock];

  ENGRAM_INLINE Rows(const Affine& f, const float* v) {
    for (int i = 0; i < kBlock; i += kFloats) store(value + i, load(v + i) * f.b + f.c);
  }
  ENGRAM_INLINE float operator[](int y) const { return value[y]; }
};

ENGRAM_INLINE Mask first_lanes(int count) {
  static constexpr float kIndex[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  return less(load_unaligned(kIndex), broadcast(static_cast<float>(count)));
}

// Walks over a span, a vector of columns at a time. `make_columns(u)` prepares the columns and
// returns a function. That one gets a row and the nearest w so far, and returns in which pixels the
// primitive is nearer.
template <typename MakeColumns>
ENGRAM_INLINE void scan(const Scan& s, const Span& span, MakeColumns make_columns) {
  for (int x = span.x0; x < span.x1; x += kFloats) {
    const Mask inside = first_lanes(span.x1 - x);
    auto hit = make_columns(load_unaligned(s.u + x));
    for (int y = span.y0; y < span.y1; ++y) {
      float* w_at = s.w + y * s.pitch + x;
      std::int32_t* code_at = s.code + y * s.pitch + x;
      const Float nearest = load_unaligned(w_at);
      Float w = Float{};
      Int code = Int{};
      const Mask nearer = inside & hit(y, nearest, w, code);
      store_unaligned(w_at, select(nearer, w, nearest));
      store_unaligned(code_at, select(nearer, code, load_unaligned(code_at)));
    }
  }
}

template <int kFront>
void scan_convex(const Scan& s, const ScreenPrimitive& p, const std::int32_t* codes,
                 const Span& span) {
  const Affine* planes = p.planes;
  const Rows rows[6] = {{planes[0], s.v}, {planes[1], s.v}, {planes[2], s.v},
                        {planes[3], s.v}, {planes[4], s.v}, {planes[5], s.v}};
  const float near_w = s.frame->near_w;
  scan(
      s, span, [&](Float u) __attribute__((always_inline)) {
        Float columns[6];
        for (int i = 0; i < 6; ++i) columns[i] = planes[i].a * u;
        return [ =, &rows ](int y, Float nearest, Float& w, Int& code)
            __attribute__((always_inline)) {
          w = columns[0] + rows[0][y];
          code = broadcast(codes[0]);
          for (int i = 1; i < kFront; ++i) {
            const Float bound = columns[i] + rows[i][y];
            code = select(less(bound, w), broadcast(codes[i]), code);
            w = min(bound, w);
          }
          Float exit = columns[kFront] + rows[kFront][y];
          for (int i = kFront + 1; i < 6; ++i) exit = max(columns[i] + rows[i][y], exit);
          return less(nearest, w) & at_most(w, broadcast(near_w)) & at_most(exit, w);
        };
      });
}

void scan_hull(const Scan& s, const ScreenPrimitive& p, const std::int32_t* codes,
               const Span& span) {
  const Affine* planes = p.planes;
  const int front = p.front_count;
  const int count = front + p.back_count;
  const float near_w = s.frame->near_w;
  const float* v = s.v;
  scan(
      s, span, [=](Float u) __attribute__((always_inline)) {
        return [=](int y, Float nearest, Float& w, Int& code) __attribute__((always_inline)) {
          w = planes[0].a * u + (planes[0].b * v[y] + planes[0].c);
          code = broadcast(codes[0]);
          for (int i = 1; i < front; ++i) {
            const Float bound = planes[i].a * u + (planes[i].b * v[y] + planes[i].c);
            code = select(less(bound, w), broadcast(codes[i]), code);
            w = min(bound, w);
          }
          Mask hit = less(nearest, w) & at_most(w, broadcast(near_w));
          for (int i = front; i < count && any(hit); ++i) {
            hit = hit & at_most(planes[i].a * u + (planes[i].b * v[y] + planes[i].c), w);
          }
          return hit;
        };
      });
}

void scan_plane(const Scan& s, const ScreenPrimitive& p, const std::int32_t* codes,
                const Span& span) {
  const Affine plane = p.planes[0];
  const Affine x = p.local[0];
  const Affine y_axis = p.local[1];
  const Rows rows(plane, s.v);
  const Rows rows_x(x, s.v);
  const Rows rows_y(y_axis, s.v);
  const float near_w = s.frame->near_w;
  scan(
      s, span, [&](Float u) __attribute__((always_inline)) {
        const Float column = plane.a * u;
        const Float column_x = x.a * u;
        const Float column_y = y_axis.a * u;
        return [ =, &rows, &rows_x, &rows_y, &p ](int y, Float nearest, Float& w, Int& code)
            __attribute__((always_inline)) {
          w = column + rows[y];
          code = broadcast(codes[0]);
          const Mask hit = less(nearest, w) & at_most(w, broadcast(near_w));
          if (!any(hit)) return hit;
          return hit & at_most(abs(p.offset[0] * w + (column_x + rows_x[y])), p.limit[0] * w) &
                 at_most(abs(p.offset[1] * w + (column_y + rows_y[y])), p.limit[1] * w);
        };
      });
}

// A conic's coefficients along each row.
struct ConicRows {
  alignas(64) float b[kBlock];
  alignas(64) float disc[kBlock];
  alignas(64) float disc_u[kBlock];

  ENGRAM_INLINE ConicRows(const Conic& conic, const float* v_image) {
    for (int i = 0; i < kBlock; i += kFloats) {
      const Float v = load(v_image + i) - conic.v0;
      store(b + i, conic.bv * v + conic.b1);
      store(disc + i, (conic.vv * v + conic.v) * v + conic.one);
      store(disc_u + i, conic.uv * v + conic.u);
    }
  }
};

// And along a vector of columns.
struct ConicColumns {
  Float du, uu, bu;

  ENGRAM_INLINE ConicColumns(const Conic& conic, Float u)
      : du(u - conic.u0), uu(conic.uu * du), bu(conic.bu * du) {}
  ENGRAM_INLINE Float discriminant(const ConicRows& rows, int y) const {
    return (uu + rows.disc_u[y]) * du + rows.disc[y];
  }
  ENGRAM_INLINE Float middle(const ConicRows& rows, int y) const { return bu + rows.b[y]; }
};

void scan_ball(const Scan& s, const ScreenPrimitive& p, const std::int32_t* codes,
               const Span& span) {
  const ConicRows rows(p.conic[0], s.v);
  const float near_w = s.frame->near_w;
  scan(
      s, span, [&](Float u) __attribute__((always_inline)) {
        const ConicColumns columns(p.conic[0], u);
        return [ =, &rows ](int y, Float nearest, Float& w, Int& code)
            __attribute__((always_inline)) {
          const Float disc = columns.discriminant(rows, y);
          const Mask crossed = at_most(Float{}, disc);
          w = columns.middle(rows, y) + sqrt(max(disc, Float{}));
          code = broadcast(codes[0]);
          return crossed & less(nearest, w) & at_most(w, broadcast(near_w));
        };
      });
}

void scan_capsule(const Scan& s, const ScreenPrimitive& p, const std::int32_t* codes,
                  const Span& span) {
  const ConicRows rows[3] = {{p.conic[0], s.v}, {p.conic[1], s.v}, {p.conic[2], s.v}};
  const Affine axis = p.local[0];
  const Rows rows_axis(axis, s.v);
  const float offset = p.offset[0];
  const float limit = p.limit[0];
  const float near_w = s.frame->near_w;
  scan(
      s, span, [&](Float u) __attribute__((always_inline)) {
        const ConicColumns columns[3] = {{p.conic[0], u}, {p.conic[1], u}, {p.conic[2], u}};
        const Float column_axis = axis.a * u;
        return [ =, &rows, &rows_axis ](int y, Float nearest, Float& w, Int& code)
            __attribute__((always_inline)) {
          Float disc[3];
          Mask crossed[3];
          for (int i = 0; i < 3; ++i) {
            disc[i] = columns[i].discriminant(rows[i], y);
            crossed[i] = at_most(Float{}, disc[i]);
          }
          w = Float{};
          code = broadcast(codes[0]);
          if (any(crossed[0])) {
            const Float entry = columns[0].middle(rows[0], y) + sqrt(max(disc[0], Float{}));
            const Float z = abs(offset * entry + (column_axis + rows_axis[y]));
            w = select(crossed[0] & at_most(z, limit * entry), entry, w);
          }
          for (int i = 1; i < 3; ++i) {
            if (!any(crossed[i])) continue;
            const Float entry = columns[i].middle(rows[i], y) + sqrt(max(disc[i], Float{}));
            const Mask first = crossed[i] & less(w, entry);
            w = select(first, entry, w);
            code = select(first, broadcast(codes[i]), code);
          }
          return less(nearest, w) & at_most(w, broadcast(near_w));
        };
      });
}

void scan_cylinder(const Scan& s, const ScreenPrimitive& p, const std::int32_t* codes,
                   const Span& span) {
  const ConicRows rows(p.conic[0], s.v);
  const Rows caps[2] = {{p.planes[0], s.v}, {p.planes[1], s.v}};
  const float near_w = s.frame->near_w;
  const bool has_front = p.front_count > 0;
  const bool within = p.camera_within_side;
  const std::int32_t cap_code = has_front ? codes[1] : 0;
  scan(
      s, span, [&](Float u) __attribute__((always_inline)) {
        const ConicColumns columns(p.conic[0], u);
        const Float column[2] = {p.planes[0].a * u, p.planes[1].a * u};
        return [ =, &rows, &caps ](int y, Float nearest, Float& w, Int& code)
            __attribute__((always_inline)) {
          const Float disc = columns.discriminant(rows, y);
          const Mask crossed = at_most(Float{}, disc);
          const Float middle = columns.middle(rows, y);
          const Float root = sqrt(max(disc, Float{}));
          const Float cap = column[0] + caps[0][y];
          Float exit = column[1] + caps[1][y];
          if (within) {  // then there is a front cap (frame_builder_shapes.cc)
            w = cap;
            code = broadcast(cap_code);
            exit = max(exit, middle + root);
          } else {
            w = middle + root;
            code = broadcast(codes[0]);
            exit = max(exit, middle - root);
            if (has_front) {
              code = select(less(cap, w), broadcast(cap_code), code);
              w = min(cap, w);
            } else {
              exit = max(exit, cap);
            }
          }
          return crossed & less(nearest, w) & at_most(w, broadcast(near_w)) & at_most(exit, w);
        };
      });
}

void scan_primitive(const Scan& s, const ScreenPrimitive& p, const Span& span) {
  const auto* codes = reinterpret_cast<const std::int32_t*>(s.frame->codes) + p.surface;
  switch (p.kind) {
    case PrimitiveKind::kConvex:
      if (p.front_count + p.back_count != 6) return scan_hull(s, p, codes, span);
      if (p.front_count == 1) return scan_convex<1>(s, p, codes, span);
      if (p.front_count == 2) return scan_convex<2>(s, p, codes, span);
      if (p.front_count == 3) return scan_convex<3>(s, p, codes, span);
      return scan_hull(s, p, codes, span);
    case PrimitiveKind::kBall:
      return scan_ball(s, p, codes, span);
    case PrimitiveKind::kCapsule:
      return scan_capsule(s, p, codes, span);
    case PrimitiveKind::kCylinder:
      return scan_cylinder(s, p, codes, span);
    case PrimitiveKind::kPlane:
      return scan_plane(s, p, codes, span);
  }
}

}  // namespace
}  // namespace engram::cpu
