// Kernel, first half: which surface each pixel sees. Included by cpu_kernel_*.cc only.
#pragma once

#include "core/math/simd.h"
#include "render/cpu/frame_data.h"

namespace engram::cpu {
namespace {

using namespace simd;

ENGRAM_INLINE float along_row(const Affine& f, float v) { return f.b * v + f.c; }

// Walks over a primitive's pixels, a vector at a time. `make_row(v)` prepares a row and returns a
// function. That one gets u and the nearest w so far, and returns in which pixels the primitive is
// nearer.
template <typename MakeRow>
ENGRAM_INLINE void scan(const FrameData& frame, const Band& band, const ScreenPrimitive& primitive,
                        MakeRow make_row) {
  const int y0 = primitive.rect.y0 > band.y0 ? primitive.rect.y0 : band.y0;
  const int y1 = primitive.rect.y1 < band.y1 ? primitive.rect.y1 : band.y1;
  const int x0 = primitive.rect.x0 & -kFloats;
  for (int y = y0; y < y1; ++y) {
    float* w_row = band.w + static_cast<std::ptrdiff_t>(y - band.y0) * band.width;
    std::int32_t* id_row = band.id + static_cast<std::ptrdiff_t>(y - band.y0) * band.width;
    auto hit = make_row(frame.v[y]);
    for (int x = x0; x < primitive.rect.x1; x += kFloats) {
      const Float nearest = load(w_row + x);
      Float w;
      Int id;
      const Mask nearer = hit(load(frame.u + x), nearest, w, id);
      if (!any(nearer)) continue;
      store(w_row + x, select(nearer, w, nearest));
      store(id_row + x, select(nearer, id, load(id_row + x)));
    }
  }
}

// Convex bodies. A ray enters through the last of the front planes, which bound w from above,
// unless it has left through a back plane before. The number of front planes is a constant if it is
// small.
template <int kFront>
void trace_convex(const FrameData& frame, const Band& band, const ScreenPrimitive& primitive) {
  constexpr int kBack = 6 - kFront;  // boxes
  const Affine* planes = primitive.planes;
  const float near_w = frame.near_w;
  const int surface = primitive.surface;
  scan(
      frame, band, primitive, [=](float v) __attribute__((always_inline)) {
        float row[6];
        for (int i = 0; i < 6; ++i) row[i] = along_row(planes[i], v);
        return [=](Float u, Float nearest, Float & w, Int & id) __attribute__((always_inline)) {
          w = planes[0].a * u + row[0];
          id = broadcast(surface);
          for (int i = 1; i < kFront; ++i) {
            const Float bound = planes[i].a * u + row[i];
            id = select(less(bound, w), broadcast(surface + i), id);
            w = min(bound, w);
          }
          Mask hit = less(nearest, w) & at_most(w, broadcast(near_w));
          if (!any(hit)) return hit;
          Float exit = planes[kFront].a * u + row[kFront];
          for (int i = kFront + 1; i < kFront + kBack; ++i) {
            exit = max(planes[i].a * u + row[i], exit);
          }
          return hit & at_most(exit, w);
        };
      });
}

// Traces a hull of any number of planes.
void trace_hull(const FrameData& frame, const Band& band, const ScreenPrimitive& primitive) {
  const Affine* planes = primitive.planes;
  const int front = primitive.front_count;
  const int count = front + primitive.back_count;
  const float near_w = frame.near_w;
  const int surface = primitive.surface;
  scan(
      frame, band, primitive, [=](float v) __attribute__((always_inline)) {
        return [=](Float u, Float nearest, Float & w, Int & id) __attribute__((always_inline)) {
          w = planes[0].a * u + along_row(planes[0], v);
          id = broadcast(surface);
          for (int i = 1; i < front; ++i) {
            const Float bound = planes[i].a * u + along_row(planes[i], v);
            id = select(less(bound, w), broadcast(surface + i), id);
            w = min(bound, w);
          }
          Mask hit = less(nearest, w) & at_most(w, broadcast(near_w));
          for (int i = front; i < count && any(hit); ++i) {
            hit = hit & at_most(planes[i].a * u + along_row(planes[i], v), w);
          }
          return hit;
        };
      });
}

void trace_plane(const FrameData& frame, const Band& band, const ScreenPrimitive& primitive) {
  const Affine plane = primitive.planes[0];
  const Affine x = primitive.local[0];
  const Affine y = primitive.local[1];
  const float offset_x = primitive.offset[0];
  const float offset_y = primitive.offset[1];
  const float limit_x = primitive.limit[0];
  const float limit_y = primitive.limit[1];
  const float near_w = frame.near_w;
  const int surface = primitive.surface;
  scan(
      frame, band, primitive, [=](float v) __attribute__((always_inline)) {
        const float row = along_row(plane, v);
        const float row_x = along_row(x, v);
        const float row_y = along_row(y, v);
        return [=](Float u, Float nearest, Float & w, Int & id) __attribute__((always_inline)) {
          w = plane.a * u + row;
          id = broadcast(surface);
          const Mask hit = less(nearest, w) & at_most(w, broadcast(near_w));
          if (!any(hit)) return hit;
          return hit & at_most(abs(offset_x * w + (x.a * u + row_x)), limit_x * w) &
                 at_most(abs(offset_y * w + (y.a * u + row_y)), limit_y * w);
        };
      });
}

// A conic along one row.
struct ConicRow {
  float u0, b, bu, disc, disc_u, uu;

  ENGRAM_INLINE ConicRow(const Conic& conic, float v_image) : u0(conic.u0) {
    const float v = v_image - conic.v0;
    b = conic.bv * v + conic.b1;
    bu = conic.bu;
    disc = (conic.vv * v + conic.v) * v + conic.one;
    disc_u = conic.uv * v + conic.u;
    uu = conic.uu;
  }
  ENGRAM_INLINE Float discriminant(Float du) const { return (uu * du + disc_u) * du + disc; }
  ENGRAM_INLINE Float middle(Float du) const { return bu * du + b; }
};

void trace_ball(const FrameData& frame, const Band& band, const ScreenPrimitive& primitive) {
  const Conic conic = primitive.conic[0];
  const float near_w = frame.near_w;
  const int surface = primitive.surface;
  scan(
      frame, band, primitive, [=](float v) __attribute__((always_inline)) {
        const ConicRow row(conic, v);
        return [=](Float u, Float nearest, Float & w, Int & id) __attribute__((always_inline)) {
          const Float du = u - row.u0;
          const Float disc = row.discriminant(du);
          const Mask crossed = at_most(Float{}, disc);
          if (!any(crossed)) return crossed;
          w = row.middle(du) + sqrt(max(disc, Float{}));
          id = broadcast(surface);
          return crossed & less(nearest, w) & at_most(w, broadcast(near_w));
        };
      });
}

// The first of three entries: into the side, within the straight part, and into the balls at the
// ends.
void trace_capsule(const FrameData& frame, const Band& band, const ScreenPrimitive& primitive) {
  const ScreenPrimitive& p = primitive;
  const float near_w = frame.near_w;
  scan(
      frame, band, primitive, [ near_w, &p ](float v) __attribute__((always_inline)) {
        const ConicRow side(p.conic[0], v);
        const ConicRow ends[2] = {{p.conic[1], v}, {p.conic[2], v}};
        const Affine axis = p.local[0];
        const float row_axis = along_row(axis, v);
        const float offset = p.offset[0];
        const float limit = p.limit[0];
        const int surface = p.surface;
        return [=](Float u, Float nearest, Float & w, Int & id) __attribute__((always_inline)) {
          w = Float{};
          id = broadcast(surface);
          Float du = u - side.u0;
          Float disc = side.discriminant(du);
          Mask crossed = at_most(Float{}, disc);
          if (any(crossed)) {
            const Float entry = side.middle(du) + sqrt(max(disc, Float{}));
            const Float z = abs(offset * entry + (axis.a * u + row_axis));
            w = select(crossed & at_most(z, limit * entry), entry, w);
          }
          for (int i = 0; i < 2; ++i) {
            du = u - ends[i].u0;
            disc = ends[i].discriminant(du);
            crossed = at_most(Float{}, disc);
            if (!any(crossed)) continue;
            const Float entry = ends[i].middle(du) + sqrt(max(disc, Float{}));
            const Mask first = crossed & less(w, entry);
            w = select(first, entry, w);
            id = select(first, broadcast(surface + 1 + i), id);
          }
          return less(nearest, w) & at_most(w, broadcast(near_w));
        };
      });
}

// The infinite cylinder, cut by the planes of its caps.
void trace_cylinder(const FrameData& frame, const Band& band, const ScreenPrimitive& primitive) {
  const ScreenPrimitive& p = primitive;
  const float near_w = frame.near_w;
  scan(
      frame, band, primitive, [ near_w, &p ](float v) __attribute__((always_inline)) {
        const ConicRow side(p.conic[0], v);
        const Affine* planes = p.planes;
        const float row[2] = {along_row(planes[0], v), along_row(planes[1], v)};
        const bool has_front = p.front_count > 0;
        const bool within = p.camera_within_side;
        const int surface = p.surface;
        return [=](Float u, Float nearest, Float & w, Int & id) __attribute__((always_inline)) {
          const Float du = u - side.u0;
          const Float disc = side.discriminant(du);
          const Mask crossed = at_most(Float{}, disc);
          if (!any(crossed)) return crossed;
          const Float middle = side.middle(du);
          const Float root = sqrt(max(disc, Float{}));
          const Float cap = planes[0].a * u + row[0];
          Float exit = planes[1].a * u + row[1];
          if (within) {  // then there is a front cap (frame_builder_shapes.cc)
            w = cap;
            id = broadcast(surface + 1);
            exit = max(exit, middle + root);
          } else {
            w = middle + root;
            id = broadcast(surface);
            exit = max(exit, middle - root);
            if (has_front) {
              id = select(less(cap, w), broadcast(surface + 1), id);
              w = min(cap, w);
            } else {
              exit = max(exit, cap);
            }
          }
          return crossed & less(nearest, w) & at_most(w, broadcast(near_w)) & at_most(exit, w);
        };
      });
}

void trace_primitive(const FrameData& frame, const Band& band, const ScreenPrimitive& primitive) {
  switch (primitive.kind) {
    case PrimitiveKind::kConvex:
      if (primitive.front_count + primitive.back_count != 6) {
        return trace_hull(frame, band, primitive);
      }
      if (primitive.front_count == 1) return trace_convex<1>(frame, band, primitive);
      if (primitive.front_count == 2) return trace_convex<2>(frame, band, primitive);
      if (primitive.front_count == 3) return trace_convex<3>(frame, band, primitive);
      return trace_hull(frame, band, primitive);
    case PrimitiveKind::kBall:
      return trace_ball(frame, band, primitive);
    case PrimitiveKind::kCapsule:
      return trace_capsule(frame, band, primitive);
    case PrimitiveKind::kCylinder:
      return trace_cylinder(frame, band, primitive);
    case PrimitiveKind::kPlane:
      return trace_plane(frame, band, primitive);
  }
}

void trace(const FrameData& frame, const Band& band) {
  const std::ptrdiff_t count = static_cast<std::ptrdiff_t>(band.y1 - band.y0) * band.width;
  for (std::ptrdiff_t i = 0; i < count; i += kFloats) {
    store(band.w + i, broadcast(frame.far_w));
    store(band.id + i, Int{});
  }
  for (int i = 0; i < frame.primitive_count; ++i) {
    const ScreenPrimitive& primitive = *frame.primitives[i];
    const Rect& rect = primitive.rect;
    if (rect.y0 < band.y1 && rect.y1 > band.y0) trace_primitive(frame, band, primitive);
  }
}

}  // namespace
}  // namespace engram::cpu
