// Kernel: how much of each light arrives at each pixel's point. Included by cpu_kernel_*.cc only.
#pragma once

#include "render/cpu_frame.h"
#include "render/cpu_simd.h"

namespace engram::cpu {
namespace {

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

// Where a ray p + s r is inside of something; empty if `leave` is before `enter`.
struct Inside {
  Float enter, leave;
};

ENGRAM_INLINE Mask occupied(const Inside& inside) {
  return at_most(inside.enter, inside.leave) & less(splat(kShadowStart), inside.leave);
}

// Inside f + s g <= 1.
ENGRAM_INLINE void cut(Inside& inside, Float f, float g) {
  constexpr float kParallel = 1e-9F;
  const bool backwards = g < 0.0F;
  const float slope =
      backwards ? (g > -kParallel ? -kParallel : g) : (g < kParallel ? kParallel : g);
  const Float bound = (1.0F - f) * (1.0F / slope);
  if (backwards) {
    inside.enter = max(inside.enter, bound);
  } else {
    inside.leave = min(inside.leave, bound);
  }
}

// Inside (q + s r)' form (q + s r) <= 1.
ENGRAM_INLINE Inside quadric(const float* m, const Points& q, const float* r) {
  const float mr[3] = {m[0] * r[0] + m[3] * r[1] + m[4] * r[2],
                       m[3] * r[0] + m[1] * r[1] + m[5] * r[2],
                       m[4] * r[0] + m[5] * r[1] + m[2] * r[2]};
  const float exact = dot(mr, r);
  const float a = exact > 1e-6F ? exact : 1e-6F;  // rays along a cylinder
  const Float b = dot(mr, q);
  const Float c = m[0] * q.x * q.x + m[1] * q.y * q.y + m[2] * q.z * q.z +
                  2.0F * (m[3] * q.x * q.y + m[4] * q.x * q.z + m[5] * q.y * q.z) - 1.0F;
  const Float disc = b * b - a * c;
  const Float root = sqrt(max(disc, Float{}));
  const Mask met = at_most(Float{}, disc);
  return {select(met, (-b - root) * (1.0F / a), splat(1.0F)),
          select(met, (root - b) * (1.0F / a), splat(-1.0F))};
}

ENGRAM_INLINE Points minus(const Points& p, const float* center, const float* axis, float along) {
  return {p.x - (center[0] + along * axis[0]), p.y - (center[1] + along * axis[1]),
          p.z - (center[2] + along * axis[2])};
}

// Capsules and cylinders.
Mask shadow_of_bar(const Primitive& primitive, const Points& p, const float* ray) {
  const Occluder& o = primitive.occluder;
  const Points q = minus(p, o.center, o.axis, 0.0F);
  Inside inside = quadric(o.form, q, ray);
  const Float height = dot(o.axis, q) * (1.0F / o.half_length);
  const float climb = dot(o.axis, ray) / o.half_length;
  cut(inside, height, climb);
  cut(inside, -height, -climb);
  Mask dark = occupied(inside);
  if (primitive.kind == PrimitiveKind::kCylinder) return dark;
  const float ball[6] = {o.end, o.end, o.end, 0, 0, 0};
  for (int i = 0; i < 2; ++i) {
    const float along = i == 0 ? o.half_length : -o.half_length;
    dark = dark | occupied(quadric(ball, minus(p, o.center, o.axis, along), ray));
  }
  return dark;
}

Mask shadow_of_hull(const Primitive& primitive, const Points& p, const float* ray) {
  Inside inside = {splat(kShadowStart), splat(1e9F)};
  const int count = primitive.front_count + primitive.back_count;
  for (int i = 0; i < count; ++i) {
    // w on a plane is the plane's equation, scaled so that it is 1 there.
    const Affine& plane = primitive.planes[i];
    const float normal[3] = {plane.a, plane.b, plane.c};
    const float sign = i < primitive.front_count ? -1.0F : 1.0F;
    const Float f = dot(normal, p);
    cut(inside, (f - 1.0F) * sign + 1.0F, dot(normal, ray) * sign);
  }
  return occupied(inside);
}

Mask shadow_of(const Primitive& primitive, const Points& p, const float* ray) {
  switch (primitive.kind) {
    case PrimitiveKind::kConvex:
      return shadow_of_hull(primitive, p, ray);
    case PrimitiveKind::kBall: {
      const Occluder& o = primitive.occluder;
      return occupied(quadric(o.form, minus(p, o.center, o.axis, 0.0F), ray));
    }
    case PrimitiveKind::kCapsule:
    case PrimitiveKind::kCylinder:
      return shadow_of_bar(primitive, p, ray);
    case PrimitiveKind::kPlane:
      break;
  }
  return less(p.x, p.x);
}

// A ball around the points of a vector.
struct Bounds {
  float center[3];
  float radius;
};

ENGRAM_INLINE Bounds bounds_of(const Points& p, Mask seen) {
  float low[3];
  float high[3];
  const Float* axes[3] = {&p.x, &p.y, &p.z};
  Bounds bounds = {};
  float square = 0;
  for (int k = 0; k < 3; ++k) {
    const Float from = select(seen, *axes[k], splat(1e9F));
    const Float to = select(seen, *axes[k], splat(-1e9F));
    low[k] = from[0];
    high[k] = to[0];
    for (int i = 1; i < kLanes; ++i) {
      low[k] = from[i] < low[k] ? from[i] : low[k];
      high[k] = to[i] > high[k] ? to[i] : high[k];
    }
    bounds.center[k] = 0.5F * (low[k] + high[k]);
    square += (high[k] - low[k]) * (high[k] - low[k]);
  }
  bounds.radius = 0.5F * __builtin_sqrtf(square);
  return bounds;
}

// Whether a ray from one of the points can meet the ball around a primitive.
ENGRAM_INLINE bool can_meet(const Bounds& points, const Occluder& o, const float* ray) {
  const float d[3] = {o.center[0] - points.center[0], o.center[1] - points.center[1],
                      o.center[2] - points.center[2]};
  const float reach = (o.radius + points.radius) * 1.001F + 1e-4F;
  const float along = dot(d, ray);
  if (along < -reach) return false;
  return dot(d, d) - along * along <= reach * reach;
}

// How much of each light arrives at points that are known by u, v and depth, 0..1.
void find_shadows(const Frame& frame, Int ids, Float u, float v, Float depth, Float* arriving) {
  for (int i = 0; i < frame.light_count; ++i) arriving[i] = splat(1.0F);
  const Mask all_lanes = equal(ids, ids);
  const Mask seen = without(all_lanes, equal(ids, Int{}));
  if (!any(seen)) return;
  const Points p = {u * depth, v * depth, depth};
  const Bounds bounds = bounds_of(p, seen);
  for (int light = 0; light < frame.light_count; ++light) {
    const int begin = frame.ray_begin[light];
    const int end = frame.ray_begin[light + 1];
    if (begin == end) continue;
    Float lit = Float{};
    for (int r = begin; r < end; ++r) {
      Mask dark = less(u, u);
      for (int i = 0; i < frame.primitive_count && !all(dark); ++i) {
        const Primitive& primitive = *frame.primitives[i];
        if (!can_meet(bounds, primitive.occluder, frame.ray[r])) continue;
        // Lambert's law darkens surfaces that face away from the light; geoms are convex.
        const Int face = ids - primitive.surface;
        const Mask own = at_most(Float{}, to_float(face)) &
                         less(to_float(face), splat(static_cast<float>(primitive.surface_count)));
        dark = dark | without(shadow_of(primitive, p, frame.ray[r]), own);
      }
      lit += select(dark, Float{}, splat(1.0F));
    }
    arriving[light] = lit * (1.0F / static_cast<float>(end - begin));
  }
}

}  // namespace
}  // namespace engram::cpu
