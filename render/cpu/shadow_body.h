// Kernel: how much of each light arrives at each pixel's point. Included by cpu_kernel_*.cc only.
#pragma once

#include "core/math/simd.h"
#include "render/cpu/frame_data.h"

namespace engram::cpu {
namespace {

using namespace simd;

// Points in camera axes.
struct Points {
  Float x, y, z;
};

constexpr float kShadowStart = 1e-3F;  // m; keeps touching geoms from speckling each other

ENGRAM_INLINE Float dot(const float* a, const Points& p) {
  return a[0] * p.x + a[1] * p.y + a[2] * p.z;
}

ENGRAM_INLINE float dot(const float* a, const float* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

ENGRAM_INLINE Points minus(const Points& p, const float* center, const float* axis, float along) {
  return {p.x - (center[0] + along * axis[0]), p.y - (center[1] + along * axis[1]),
          p.z - (center[2] + along * axis[2])};
}

// Interval of s in which a ray p + s r is inside of something; empty if `leave` is before `enter`.
struct Inside {
  Float enter, leave;
};

ENGRAM_INLINE Mask occupied(const Inside& inside) {
  return at_most(inside.enter, inside.leave) & less(broadcast(kShadowStart), inside.leave);
}

// Inside f + s g <= 1, for rays of one direction.
struct Cut {
  bool backwards;
  float reciprocal;  // of g

  Cut() = default;
  ENGRAM_INLINE explicit Cut(float g) : backwards(g < 0.0F) {
    constexpr float kParallel = 1e-9F;
    const float slope =
        backwards ? (g > -kParallel ? -kParallel : g) : (g < kParallel ? kParallel : g);
    reciprocal = 1.0F / slope;
  }
  ENGRAM_INLINE void apply(Inside& inside, Float f) const {
    const Float bound = (1.0F - f) * reciprocal;
    if (backwards) {
      inside.enter = max(inside.enter, bound);
    } else {
      inside.leave = min(inside.leave, bound);
    }
  }
};

// Inside (q + s r)' form (q + s r) <= 1, for rays of one direction.
struct Quadric {
  float m[6], mr[3];
  float a, reciprocal;

  ENGRAM_INLINE Quadric(const float* form, const float* r) {
    for (int i = 0; i < 6; ++i) m[i] = form[i];
    mr[0] = m[0] * r[0] + m[3] * r[1] + m[4] * r[2];
    mr[1] = m[3] * r[0] + m[1] * r[1] + m[5] * r[2];
    mr[2] = m[4] * r[0] + m[5] * r[1] + m[2] * r[2];
    const float exact = dot(mr, r);
    a = exact > 1e-6F ? exact : 1e-6F;  // rays along a cylinder
    reciprocal = 1.0F / a;
  }
  ENGRAM_INLINE Inside inside(const Points& q) const {
    const Float b = dot(mr, q);
    const Float c = m[0] * q.x * q.x + m[1] * q.y * q.y + m[2] * q.z * q.z +
                    2.0F * (m[3] * q.x * q.y + m[4] * q.x * q.z + m[5] * q.y * q.z) - 1.0F;
    const Float disc = b * b - a * c;
    const Float root = sqrt(max(disc, Float{}));
    const Mask met = at_most(Float{}, disc);
    return {select(met, (-b - root) * reciprocal, broadcast(1.0F)),
            select(met, (root - b) * reciprocal, broadcast(-1.0F))};
  }
};

// A block of pixels that share their search for what may be between them and the lights.
struct ShadowTile {
  static constexpr int kMax = kBlock * kBlock;

  int count = 0;              // pixels, row after row
  alignas(64) float x[kMax];  // points in camera axes
  alignas(64) float y[kMax];
  alignas(64) float z[kMax];
  alignas(64) std::int32_t id[kMax];
  alignas(64) float lit[kMaxLights][kMax];  // how much of each light arrives, 0..1
  Mask dark[kFloats][kMax / kFloats];       // of some rays of a light
};

// Darkens the pixels from which `meets` says that a ray meets the primitive.
template <typename Meets>
ENGRAM_INLINE void darken(ShadowTile& tile, Mask* dark, const ScreenPrimitive& primitive,
                          Meets meets) {
  for (int i = 0; i < tile.count; i += kFloats, ++dark) {
    if (all(*dark)) continue;
    // Lambert's law darkens surfaces that face away from the light; geoms are convex.
    const Float face = to_float(load(tile.id + i) - primitive.surface);
    const Mask own =
        at_most(Float{}, face) & less(face, broadcast(static_cast<float>(primitive.surface_count)));
    const Points p = {load(tile.x + i), load(tile.y + i), load(tile.z + i)};
    *dark = *dark | without(meets(p), own);
  }
}

void darken_by_ball(ShadowTile& tile, Mask* dark, const ScreenPrimitive& primitive,
                    const float* ray) {
  const Occluder& o = primitive.occluder;
  const Quadric ball(o.form, ray);
  darken(
      tile, dark, primitive, [&](const Points& p) __attribute__((always_inline)) {
        return occupied(ball.inside(minus(p, o.center, o.axis, 0.0F)));
      });
}

// Capsules and cylinders.
void darken_by_bar(ShadowTile& tile, Mask* dark, const ScreenPrimitive& primitive,
                   const float* ray) {
  const Occluder& o = primitive.occluder;
  const float end_form[6] = {o.end, o.end, o.end, 0, 0, 0};
  const Quadric side(o.form, ray);
  const Quadric end(end_form, ray);
  const float climb = dot(o.axis, ray) / o.half_length;
  const Cut up(climb);
  const Cut down(-climb);
  const bool has_ends = primitive.kind == PrimitiveKind::kCapsule;
  darken(
      tile, dark, primitive, [&](const Points& p) __attribute__((always_inline)) {
        const Points q = minus(p, o.center, o.axis, 0.0F);
        Inside inside = side.inside(q);
        const Float height = dot(o.axis, q) * (1.0F / o.half_length);
        up.apply(inside, height);
        down.apply(inside, -height);
        Mask met = occupied(inside);
        if (!has_ends) return met;
        for (int i = 0; i < 2; ++i) {
          const float along = i == 0 ? o.half_length : -o.half_length;
          met = met | occupied(end.inside(minus(p, o.center, o.axis, along)));
        }
        return met;
      });
}

void darken_by_hull(ShadowTile& tile, Mask* dark, const ScreenPrimitive& primitive,
                    const float* ray) {
  constexpr int kPrepared = 32;
  const int count = primitive.front_count + primitive.back_count;
  // w on a plane is the plane's equation, scaled so that it is 1 there.
  const auto sign_of = [&](int i) { return i < primitive.front_count ? -1.0F : 1.0F; };
  const auto cut_of = [&](int i) {
    const float normal[3] = {primitive.planes[i].a, primitive.planes[i].b, primitive.planes[i].c};
    return Cut(dot(normal, ray) * sign_of(i));
  };
  Cut cuts[kPrepared];
  for (int i = 0; i < count && i < kPrepared; ++i) cuts[i] = cut_of(i);
  darken(
      tile, dark, primitive, [&](const Points& p) __attribute__((always_inline)) {
        Inside inside = {broadcast(kShadowStart), broadcast(1e9F)};
        for (int i = 0; i < count; ++i) {
          const Affine& plane = primitive.planes[i];
          const float normal[3] = {plane.a, plane.b, plane.c};
          const Float f = (dot(normal, p) - 1.0F) * sign_of(i) + 1.0F;
          (i < kPrepared ? cuts[i] : cut_of(i)).apply(inside, f);
        }
        return occupied(inside);
      });
}

void darken_by(ShadowTile& tile, Mask* dark, const ScreenPrimitive& primitive, const float* ray) {
  switch (primitive.kind) {
    case PrimitiveKind::kConvex:
      return darken_by_hull(tile, dark, primitive, ray);
    case PrimitiveKind::kBall:
      return darken_by_ball(tile, dark, primitive, ray);
    case PrimitiveKind::kCapsule:
    case PrimitiveKind::kCylinder:
      return darken_by_bar(tile, dark, primitive, ray);
    case PrimitiveKind::kPlane:
      return;
  }
}

// A box around the points of a tile, and a ball around that.
struct TileBounds {
  float center[3];
  float half[3];
  float radius;
};

ENGRAM_INLINE float least(Float a) {
  float result = a[0];
  for (int i = 1; i < kFloats; ++i) result = a[i] < result ? a[i] : result;
  return result;
}

ENGRAM_INLINE TileBounds bounds_of(const ShadowTile& tile) {
  TileBounds bounds = {};
  float square = 0;
  const float* axes[3] = {tile.x, tile.y, tile.z};
  for (int k = 0; k < 3; ++k) {
    Float from = broadcast(1e9F);
    Float to = broadcast(-1e9F);
    for (int i = 0; i < tile.count; i += kFloats) {
      const Mask nothing = equal(load(tile.id + i), Int{});
      const Float value = load(axes[k] + i);
      from = min(from, select(nothing, broadcast(1e9F), value));
      to = max(to, select(nothing, broadcast(-1e9F), value));
    }
    const float low = least(from);
    const float high = -least(-to);
    bounds.center[k] = 0.5F * (low + high);
    bounds.half[k] = 0.5F * (high - low);
    square += bounds.half[k] * bounds.half[k];
  }
  bounds.radius = __builtin_sqrtf(square);
  return bounds;
}

// Rays of one light, one in each lane; those beyond `count` are copies.
struct Rays {
  Float x, y, z;
  int count;

  ENGRAM_INLINE Rays(const float (*ray)[3], int from) : count(from < kFloats ? from : kFloats) {
    for (int i = 0; i < kFloats; ++i) {
      const float* of = ray[i < count ? i : 0];
      x[i] = of[0];
      y[i] = of[1];
      z[i] = of[2];
    }
  }
};

ENGRAM_INLINE Float dot(const float* a, const Rays& rays) {
  return a[0] * rays.x + a[1] * rays.y + a[2] * rays.z;
}

// Rays from a tile that may meet a primitive. The tests leave a margin for rounding.

ENGRAM_INLINE Mask may_meet_hull(const ScreenPrimitive& primitive, const TileBounds& points,
                                 const Rays& rays) {
  constexpr float kRounding = 1e-5F;
  constexpr float kParallel = 1e-9F;
  Float enter = broadcast(kShadowStart);
  Float leave = broadcast(1e9F);
  for (int i = 0; i < primitive.front_count + primitive.back_count; ++i) {
    const Affine& plane = primitive.planes[i];
    const float sign = i < primitive.front_count ? -1.0F : 1.0F;
    const float normal[3] = {plane.a, plane.b, plane.c};
    float spread = kRounding;
    for (int k = 0; k < 3; ++k) {
      spread += __builtin_fabsf(normal[k]) *
                (points.half[k] * 1.001F + __builtin_fabsf(points.center[k]) * kRounding);
    }
    const Float slope = dot(normal, rays) * sign;
    const Mask backwards = less(slope, Float{});
    // The bound if the plane were moved outwards as far as the points reach.
    const float margin = spread - (dot(normal, points.center) - 1.0F) * sign;
    const Float bound = margin / select(backwards, min(slope, broadcast(-kParallel)),
                                        max(slope, broadcast(kParallel)));
    enter = select(backwards, max(enter, bound), enter);
    leave = select(backwards, leave, min(leave, bound));
  }
  return at_most(enter, leave * 1.001F + 1e-4F);
}

// A ray from the points' middle, and the bar as much thicker and longer as the points reach.
ENGRAM_INLINE Mask may_meet_bar(const ScreenPrimitive& primitive, const TileBounds& points,
                                const Rays& rays) {
  constexpr float kRoom = 5e-4F;  // m
  const Occluder& o = primitive.occluder;
  const float radius = 1.0F / __builtin_sqrtf(o.end);
  const float reach = (radius + points.radius) * 1.01F + kRoom;
  const float q[3] = {points.center[0] - o.center[0], points.center[1] - o.center[1],
                      points.center[2] - o.center[2]};
  const float height = dot(o.axis, q);
  const Float climb = dot(o.axis, rays);
  // Across the axis. A ray along it is as one that leans a little.
  const Float a = max(1.0F - climb * climb, broadcast(1e-6F));
  const Float b = dot(q, rays) - height * climb;
  const float c = dot(q, q) - height * height - reach * reach;
  const Float disc = b * b - a * c;
  const Float root = sqrt(max(disc, Float{}));
  const Float enter = max((-b - root) / a, Float{});
  const Float leave = (root - b) / a;
  const float end = o.half_length + reach;
  const Float first = height + enter * climb;
  const Float last = height + leave * climb;
  return at_most(Float{}, disc) & at_most(Float{}, leave) &
         at_most(min(first, last), broadcast(end)) & at_most(broadcast(-end), max(first, last));
}

ENGRAM_INLINE unsigned may_meet(const ScreenPrimitive& primitive, const TileBounds& points,
                                const Rays& rays) {
  Mask mask = equal(Int{}, Int{});
  if (primitive.kind == PrimitiveKind::kConvex) {
    mask = may_meet_hull(primitive, points, rays);
  } else if (primitive.kind == PrimitiveKind::kCapsule ||
             primitive.kind == PrimitiveKind::kCylinder) {
    mask = may_meet_bar(primitive, points, rays);
  }
  return static_cast<unsigned>(bits(mask)) & ((1U << rays.count) - 1);
}

// Primitives, from `first` on, whose bounding balls a ray from one of the points can meet: a bit
// each.
ENGRAM_INLINE unsigned find_casters(const FrameData& frame, const TileBounds& points, int first,
                                    const float* ray) {
  const Casters& casters = frame.casters;
  const Float x = load(casters.x + first) - points.center[0];
  const Float y = load(casters.y + first) - points.center[1];
  const Float z = load(casters.z + first) - points.center[2];
  const Float reach = (load(casters.radius + first) + points.radius) * 1.001F + 1e-4F;
  const Float along = x * ray[0] + y * ray[1] + z * ray[2];
  const Float off = x * x + y * y + z * z - along * along;
  return static_cast<unsigned>(bits(at_most(-reach, along) & at_most(off, reach * reach)));
}

// Adds what arrives along some rays of a light.
void follow_rays(const FrameData& frame, const TileBounds& bounds, const float (*ray)[3],
                 const Rays& rays, ShadowTile& tile, float* lit) {
  for (int r = 0; r < rays.count; ++r) {
    for (int i = 0; i < tile.count; i += kFloats) {
      tile.dark[r][i / kFloats] = less(Float{}, Float{});
    }
  }
  for (int first = 0; first < frame.primitive_count; first += kFloats) {
    unsigned near = 0;
    for (int r = 0; r < rays.count; ++r) near |= find_casters(frame, bounds, first, ray[r]);
    for (; near != 0; near &= near - 1) {
      const ScreenPrimitive& primitive = *frame.primitives[first + __builtin_ctz(near)];
      for (unsigned left = may_meet(primitive, bounds, rays); left != 0; left &= left - 1) {
        const int r = __builtin_ctz(left);
        darken_by(tile, tile.dark[r], primitive, ray[r]);
      }
    }
  }
  for (int r = 0; r < rays.count; ++r) {
    for (int i = 0; i < tile.count; i += kFloats) {
      store(lit + i, load(lit + i) + select(tile.dark[r][i / kFloats], Float{}, broadcast(1.0F)));
    }
  }
}

// Part of each light that arrives at the points of a tile.
void find_shadows(const FrameData& frame, ShadowTile& tile) {
  const TileBounds bounds = bounds_of(tile);
  const bool empty = bounds.half[0] < 0;  // only background: no light matters
  for (int light = 0; light < frame.light_count; ++light) {
    const int begin = frame.ray_begin[light];
    const int end = frame.ray_begin[light + 1];
    const bool casts = begin != end && !empty;
    for (int i = 0; i < tile.count; i += kFloats) {
      store(tile.lit[light] + i, broadcast(casts ? 0.0F : 1.0F));
    }
    if (!casts) continue;
    for (int r = begin; r < end; r += kFloats) {
      follow_rays(frame, bounds, frame.ray + r, Rays(frame.ray + r, end - r), tile,
                  tile.lit[light]);
    }
    const float part = 1.0F / static_cast<float>(end - begin);
    for (int i = 0; i < tile.count; i += kFloats) {
      store(tile.lit[light] + i, load(tile.lit[light] + i) * part);
    }
  }
}

}  // namespace
}  // namespace engram::cpu
