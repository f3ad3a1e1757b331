// Kernel: projection of boxes, capsules and cylinders, a batch at a time. Included by kernel_*.cc
// only. Sums are in Eigen's order, so that every number comes out as frame_builder_shapes.cc has
// it.
#pragma once

#include "core/math/vec3.h"
#include "render/cpu/geom_batch.h"

namespace engram::cpu {
namespace {

using namespace simd;

using Vec3 = Vec3Of<Double>;
using Mat3 = Mat3Of<Double>;

ENGRAM_INLINE Vec3 all_lanes(const double* v) { return broadcast_vec3<Double>(v); }

ENGRAM_INLINE Mat3 camera_rotation(const ViewParams& camera) {
  Mat3 rotation;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) rotation(i, k) = broadcast<Double>(camera.rotation[i][k]);
  }
  return rotation;
}

// The product in Eigen's order: the last row's sum begins at its end.
ENGRAM_INLINE Vec3 product(const Mat3& m, const Vec3& a) {
  return {dot(m.row(0), a), dot(m.row(1), a), m(2, 0) * a[0] + (m(2, 1) * a[1] + m(2, 2) * a[2])};
}

// Poses of geoms in camera axes.
struct PlacedBatch {
  Vec3 center;
  Mat3 axes;
  Double finite;  // 0, or not a number

  ENGRAM_INLINE PlacedBatch(const ViewParams& camera, const GeomBatch& batch, int at) {
    const auto value = [&](int i) __attribute__((always_inline)) {
      return load(batch.pose[i].lane + at);
    };
    const Mat3 rotation = camera_rotation(camera);
    center = product(rotation, Vec3{value(9), value(10), value(11)} - all_lanes(camera.eye));
    finite = (center[0] + center[1] + center[2]) * 0.0;
    for (int i = 0; i < 3; ++i) {
      const Vec3 axis = product(rotation, {value(i), value(3 + i), value(6 + i)});
      for (int k = 0; k < 3; ++k) {
        axes(k, i) = axis[k];
        finite += axis[k] * 0.0;
      }
    }
  }
};

// Ranges of u and v, and whether the near plane spoils them.
struct Extents {
  Double low[2] = {broadcast<Double>(1e30), broadcast<Double>(1e30)};
  Double high[2] = {broadcast<Double>(-1e30), broadcast<Double>(-1e30)};
  Double spoilt = {};

  ENGRAM_INLINE void include(int k, Double from, Double to) {
    low[k] = min(from, low[k]);
    high[k] = max(to, high[k]);
  }
};

// Rectangles in pixels, whole numbers; as FrameBuilder::to_pixels().
struct Rects {
  Double x0, x1, y0, y1;
  Double empty;

  ENGRAM_INLINE Rects(const ViewParams& camera, const Extents& extents) {
    constexpr double kMargin = 0.25;
    const double columns = 0.5 * camera.width / camera.half_u;
    const double rows = 0.5 * camera.height / camera.half_v;
    const double column = 0.5 * camera.width - 0.5;
    const double row = 0.5 * camera.height - 0.5;
    const auto first = [](Double value, int size) __attribute__((always_inline)) {
      return ceil(clamp(value - kMargin, 0.0, size));
    };
    const auto last = [](Double value, int size) __attribute__((always_inline)) {
      return floor(clamp(value + kMargin, -1.0, size - 1.0)) + 1.0;
    };
    x0 = first(extents.low[0] * columns + column, camera.width);
    x1 = last(extents.high[0] * columns + column, camera.width);
    y0 = first(row - extents.high[1] * rows, camera.height);
    y1 = last(row - extents.low[1] * rows, camera.height);
    const auto none = (x0 >= x1) | (y0 >= y1);
    empty = none ? broadcast<Double>(1) : Double{};
  }
};

ENGRAM_INLINE void store_visibility(const PlacedBatch& placed, const Extents& extents,
                                    const Rects& rects, Double unseen, int at, Visibility& out) {
  Double state = broadcast<Double>(Visibility::kVisible);
  state = rects.empty + unseen > 0.0 ? broadcast<Double>(Visibility::kCulled) : state;
  const auto good = (extents.spoilt == 0.0) & (placed.finite == 0.0);
  state = good ? state : broadcast<Double>(Visibility::kSingle);
  store(out.state.lane + at, state);
  store(out.x0.lane + at, rects.x0);
  store(out.x1.lane + at, rects.x1);
  store(out.y0.lane + at, rects.y0);
  store(out.y1.lane + at, rects.y1);
  store(out.center_z.lane + at, placed.center[2]);
}

ENGRAM_INLINE Double plane_divisor(Double distance) {
  return abs(distance) < 1e-7 ? broadcast<Double>(1e-7) : distance;
}

ENGRAM_INLINE void store_sides(const Vec3& f, int at, Sides& out) {
  store(out.a.lane + at, f[0]);
  store(out.b.lane + at, f[1]);
  store(out.c.lane + at, f[2]);
}

ENGRAM_INLINE void store_bound(const Vec3& normal, Double distance, int at, Sides& out) {
  const Double by = plane_divisor(distance);
  store_sides({normal[0] / by, normal[1] / by, normal[2] / by}, at, out);
}

// A number of some geoms of a batch, or of all.
constexpr int kBatchPart = kFloats < kBatch ? kFloats : kBatch;
using PartFloat = float __attribute__((vector_size(4 * kBatchPart)));
using PartInt = std::int32_t __attribute__((vector_size(4 * kBatchPart)));

ENGRAM_INLINE PartFloat part_of(const Floats& lanes, int at) {
  PartFloat value;
  __builtin_memcpy(&value, lanes.lane + at, sizeof value);
  return value;
}
ENGRAM_INLINE void put(PartFloat value, int at, Floats& lanes) {
  __builtin_memcpy(lanes.lane + at, &value, sizeof value);
}

// Colours of lights and surfaces.
ENGRAM_INLINE void light_round(const ViewParams& camera, const GeomBatch& batch, RoundLight& out) {
  for (int k = 0; k < 3; ++k) {
    for (int at = 0; at < kBatch; at += kBatchPart) {
      const PartFloat color = part_of(batch.rgba[k], at) * 255.0F;
      put(color * (camera.ambient[k] + part_of(batch.emission, at)), at, out.constant[k]);
      for (int light = 0; light < camera.light_count; ++light) {
        put(color * camera.light_color[light][k], at, out.light[light][k]);
      }
    }
  }
}

// Colours of flat surfaces, as FrameBuilder::light_flat(). `amount`: of each light.
ENGRAM_INLINE void light_flat(const ViewParams& camera, const RoundLight& lit,
                              const Floats (&amount)[kMaxLights], Ints& code) {
  constexpr float kRound = 12582912.0F;  // 1.5 * 2^23: no bits are left for a fraction
  constexpr PartFloat kMin = {};
  constexpr PartFloat kMax = kMin + 255.0F;
  for (int at = 0; at < kBatch; at += kBatchPart) {
    PartInt packed = {};
    for (int k = 0; k < 3; ++k) {
      PartFloat level = part_of(lit.constant[k], at);
      for (int light = 0; light < camera.light_count; ++light) {
        level += part_of(lit.light[light][k], at) * part_of(amount[light], at);
      }
      level = level < kMin ? kMin : level;
      level = level > kMax ? kMax : level;
      packed |= __builtin_convertvector((level + kRound) - kRound, PartInt) << (8 * k);
    }
    __builtin_memcpy(code.lane + at, &packed, sizeof packed);
  }
}

ENGRAM_INLINE void store_amounts(const ViewParams& camera, const Vec3& normal, int at,
                                 Floats (&amount)[kMaxLights]) {
  for (int light = 0; light < camera.light_count; ++light) {
    store(amount[light].lane + at, max(Double{}, dot(normal, all_lanes(camera.light[light]))));
  }
}

void cull(const ViewParams& camera, const Doubles (&position)[3], const Doubles& radius,
          Ints& visible) {
  for (int at = 0; at < kBatch; at += kDoubles) {
    const Mat3 rotation = camera_rotation(camera);
    const Vec3 center =
        product(rotation, Vec3{load(position[0].lane + at), load(position[1].lane + at),
                               load(position[2].lane + at)} -
                              all_lanes(camera.eye));
    const Double r = load(radius.lane + at);
    const auto out = (center[2] + r < camera.near) |
                     (abs(center[0]) - camera.half_u * center[2] > r * camera.side_u) |
                     (abs(center[1]) - camera.half_v * center[2] > r * camera.side_v);
    store(visible.lane + at, out ? Double{} : broadcast<Double>(1));
  }
}

void set_up_boxes(const ViewParams& camera, const GeomBatch& batch, BoxSetup& out) {
  Floats amount[6][kMaxLights];
  for (int at = 0; at < kBatch; at += kDoubles) {
    const PlacedBatch placed(camera, batch, at);
    Double half[3];
    Vec3 half_axes[3];
    for (int i = 0; i < 3; ++i) {
      half[i] = load(batch.size[i].lane + at);
      half_axes[i] = placed.axes.column(i) * half[i];
    }
    Extents extents;
    for (int corner = 0; corner < 8; ++corner) {
      Double sides[3][3];
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
          sides[i][k] = (corner >> i & 1) != 0 ? half_axes[i][k] : -half_axes[i][k];
        }
      }
      Vec3 p;
      p[0] = placed.center[0] + (sides[0][0] + sides[1][0] + sides[2][0]);
      p[1] = placed.center[1] + (sides[0][1] + sides[1][1] + sides[2][1]);
      p[2] = placed.center[2] + (sides[0][2] + (sides[1][2] + sides[2][2]));
      extents.spoilt += p[2] >= camera.near ? Double{} : broadcast<Double>(1);
      const Double nearness = 1.0 / p[2];
      for (int k = 0; k < 2; ++k) extents.include(k, p[k] * nearness, p[k] * nearness);
    }
    Double behind = broadcast<Double>(1);  // every face
    for (int face = 0; face < 6; ++face) {
      const int axis = face / 2;
      const double sign = face % 2 == 0 ? 1.0 : -1.0;
      const Vec3 direction = placed.axes.column(axis);
      const Vec3 normal = direction * broadcast<Double>(sign);
      const Double distance = sign * dot(direction, placed.center) + half[axis];
      const Double front = distance <= -1e-7 ? broadcast<Double>(1) : Double{};
      behind = front > 0.0 ? Double{} : behind;
      store(out.front[face].lane + at, front);
      store_bound(normal, distance, at, out.plane[face]);
      store_amounts(camera, normal, at, amount[face]);
    }
    store_visibility(placed, extents, Rects(camera, extents), behind, at, out.visibility);
  }
  RoundLight lit;
  light_round(camera, batch, lit);
  for (int face = 0; face < 6; ++face) light_flat(camera, lit, amount[face], out.code[face]);
}

// Adds a ball's outline to the extents, as FrameBuilder::include_ball(). Of its half axes' products
// with themselves, `square` has xx, yy, zz and `with_z` xz, yz.
ENGRAM_INLINE void include_ball(const ViewParams& camera, const Vec3& center, const Vec3& square,
                                const Double (&with_z)[2], Extents& extents) {
  const Double z = center[2];
  extents.spoilt += z - sqrt(square[2]) <= camera.near ? broadcast<Double>(1) : Double{};
  const Double a = z * z - square[2];
  for (int k = 0; k < 2; ++k) {
    const Double b = center[k] * z - with_z[k];
    const Double c = center[k] * center[k] - square[k];
    const Double root = sqrt(max(Double{}, b * b - a * c));
    extents.include(k, (b - root) / a, (b + root) / a);
  }
}

// Half axes of a ball, or of a disc without `third`.
struct HalfAxes {
  Vec3 square;
  Double with_z[2];

  ENGRAM_INLINE HalfAxes(const Mat3& axes, Double radius, bool third) {
    Vec3 h[3];
    for (int k = 0; k < 3; ++k) {
      h[k] = axes.row(k) * radius;
      if (!third) h[k][2] = Double{};
    }
    const Vec3& z = h[2];
    square = {dot(h[0], h[0]), dot(h[1], h[1]), z[0] * z[0] + (z[1] * z[1] + z[2] * z[2])};
    with_z[0] = dot(h[0], z);
    with_z[1] = dot(h[1], z);
  }
};

// The middles of rectangles, as rays.
ENGRAM_INLINE Vec3 middle_of(const ViewParams& camera, const Rects& rects) {
  alignas(64) double u[kDoubles];
  alignas(64) double v[kDoubles];
  alignas(64) std::int32_t x[kDoubles];
  alignas(64) std::int32_t y[kDoubles];
  // Rectangles of hidden geoms may be anything.
  const auto within = [](Double at, int size) __attribute__((always_inline)) {
    return ((at >= 0.0) & (at < size)) ? at : Double{};
  };
  store(x, within((rects.x0 + rects.x1) * 0.5, camera.width));
  store(y, within((rects.y0 + rects.y1) * 0.5, camera.height));
  for (int i = 0; i < kDoubles; ++i) {
    u[i] = camera.u[x[i]];
    v[i] = camera.v[y[i]];
  }
  return {load(u), load(v), broadcast<Double>(1)};
}

// Equals FrameBuilder::make_conic(). Lanes where `none` is not 0 get a conic that no ray meets.
ENGRAM_INLINE void store_conic(const Mat3& form, const Vec3& g, const Vec3& center, Double level,
                               const Vec3& middle, Double none, int at, Conics& out) {
  Double c = dot(center, g) - level;
  const Double least = 1e-9 * level;
  c = abs(c) < least ? least : c;
  const Double square = c * c;
  Mat3 q;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      q(i, k) = (g[i] * g[k] - c * form(i, k)) / square;
    }
  }
  Mat3 twice;
  for (int i = 0; i < 9; ++i) twice.at[i] = q.at[i] * 2.0;
  const Vec3 slope = product(twice, middle);
  const auto keep = [&](Floats & to, Double value) __attribute__((always_inline)) {
    store(to.lane + at, none == 0.0 ? value : Double{});
  };
  keep(out.u0, middle[0]);
  keep(out.v0, middle[1]);
  keep(out.bu, g[0] / c);
  keep(out.bv, g[1] / c);
  keep(out.b1, dot(g, middle) / c);
  keep(out.uu, q(0, 0));
  keep(out.uv, 2.0 * q(0, 1));
  keep(out.vv, q(1, 1));
  keep(out.u, slope[0]);
  keep(out.v, slope[1]);
  const Double one = 0.5 * dot(slope, middle);
  store(out.one.lane + at, none == 0.0 ? one : broadcast<Double>(-1));
}

ENGRAM_INLINE void store_form(const Vec3& f, const Vec3& origin, int at, Forms& out) {
  store(out.a.lane + at, f[0]);
  store(out.b.lane + at, f[1]);
  store(out.c.lane + at, f[2]);
  store(out.d.lane + at, -dot(f, origin));
}

// Projection of vectors across an axis.
ENGRAM_INLINE Mat3 across_of(const Vec3& axis) {
  Mat3 across;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      across(i, k) = (i == k ? 1.0 : 0.0) - axis[i] * axis[k];
    }
  }
  return across;
}

ENGRAM_INLINE Mat3 divided(const Mat3& m, Double by) {
  Mat3 result;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) result(i, k) = m(i, k) / by;
  }
  return result;
}

ENGRAM_INLINE Mat3 identity() {
  Mat3 m = {};
  for (int i = 0; i < 3; ++i) m(i, i) = broadcast<Double>(1);
  return m;
}

void set_up_capsules(const ViewParams& camera, const GeomBatch& batch, CapsuleSetup& out) {
  for (int at = 0; at < kBatch; at += kDoubles) {
    const PlacedBatch placed(camera, batch, at);
    const Double radius = load(batch.size[0].lane + at);
    const Double half_length = load(batch.size[1].lane + at);
    const Vec3 axis = placed.axes.column(2);
    const Vec3 reach = axis * half_length;
    const Vec3 ends[2] = {placed.center + reach, placed.center - reach};
    const Mat3 across = across_of(axis);
    const HalfAxes ball(placed.axes, radius, true);
    Extents extents;
    for (const Vec3& end : ends) include_ball(camera, end, ball.square, ball.with_z, extents);
    const Rects rects(camera, extents);

    const Double along = -dot(axis, placed.center);
    const Double nearest = min(half_length, max(-half_length, along));
    const Vec3 gap = placed.center + axis * nearest;
    const Double inside = sqrt(dot(gap, gap)) <= radius ? broadcast<Double>(1) : Double{};
    const Vec3 off_axis = product(across, placed.center);
    const Double end_only =
        sqrt(dot(off_axis, off_axis)) <= radius ? broadcast<Double>(1) : Double{};
    store_visibility(placed, extents, rects, inside, at, out.visibility);

    const Vec3 middle = middle_of(camera, rects);
    const Double level = radius * radius;
    store_conic(across, off_axis, placed.center, level, middle, end_only, at, out.conic[0]);
    for (int i = 0; i < 2; ++i) {
      store_conic(identity(), ends[i], ends[i], level, middle, Double{}, at, out.conic[i + 1]);
    }
    store_sides(axis, at, out.axis);
    store(out.along.lane + at, along);
    const Mat3 side_normal = divided(across, radius);
    const Mat3 end_normal = divided(identity(), radius);
    for (int light = 0; light < camera.light_count; ++light) {
      const Vec3 toward = all_lanes(camera.light[light]);
      store_form(product(side_normal, toward), placed.center, at, out.toward[0][light]);
      const Vec3 f = product(end_normal, toward);
      for (int i = 0; i < 2; ++i) store_form(f, ends[i], at, out.toward[i + 1][light]);
    }
  }
  light_round(camera, batch, out.lit);
}

void set_up_cylinders(const ViewParams& camera, const GeomBatch& batch, CylinderSetup& out) {
  Floats amount[kMaxLights];
  for (int at = 0; at < kBatch; at += kDoubles) {
    const PlacedBatch placed(camera, batch, at);
    const Double radius = load(batch.size[0].lane + at);
    const Double half_length = load(batch.size[1].lane + at);
    const Vec3 axis = placed.axes.column(2);
    const Vec3 reach = axis * half_length;
    const Mat3 across = across_of(axis);
    const HalfAxes disc(placed.axes, radius, false);
    Extents extents;
    include_ball(camera, placed.center + reach, disc.square, disc.with_z, extents);
    include_ball(camera, placed.center - reach, disc.square, disc.with_z, extents);
    const Rects rects(camera, extents);

    // Caps: at most one faces the camera; it comes first.
    const Double middle_height = dot(axis, placed.center);
    const Double top = middle_height + half_length;
    const Double bottom = half_length - middle_height;
    const auto from_above = top <= -1e-7;
    const auto from_below = bottom <= -1e-7;
    const Double has_front = (from_above | from_below) ? broadcast<Double>(1) : Double{};
    const Double top_divisor = plane_divisor(top);
    const Double bottom_divisor = plane_divisor(bottom);
    Vec3 planes[2];
    Vec3 front_normal;
    for (int k = 0; k < 3; ++k) {
      const Double of_top = axis[k] / top_divisor;
      const Double of_bottom = -axis[k] / bottom_divisor;
      planes[0][k] = from_below ? of_bottom : of_top;
      planes[1][k] = from_below ? of_top : of_bottom;
      front_normal[k] = from_above ? axis[k] : -axis[k];
    }
    for (int i = 0; i < 2; ++i) store_sides(planes[i], at, out.plane[i]);
    store(out.front_count.lane + at, has_front);
    store_amounts(camera, front_normal, at, amount);

    const Vec3 off_axis = product(across, placed.center);
    const Double level = radius * radius;
    const auto is_within = dot(off_axis, off_axis) - level < 1e-9 * radius * radius;
    const Double within = is_within ? broadcast<Double>(1) : Double{};
    store(out.within.lane + at, within);
    store_visibility(placed, extents, rects, within > has_front ? broadcast<Double>(1) : Double{},
                     at, out.visibility);
    store_conic(across, off_axis, placed.center, level, middle_of(camera, rects), Double{}, at,
                out.side);
    const Mat3 normal = divided(across, radius);
    for (int light = 0; light < camera.light_count; ++light) {
      store_form(product(normal, all_lanes(camera.light[light])), placed.center, at,
                 out.toward[light]);
    }
  }
  light_round(camera, batch, out.lit);
  light_flat(camera, out.lit, amount, out.code);
}

// Ranks several vectors of depths at once, as each of the others is read for all of them.
template <int kVectors>
ENGRAM_INLINE void count_nearer(const float* depth, int count, const float* own,
                                std::int32_t* nearer) {
  Float here[kVectors];
  Int sum[kVectors];
  for (int i = 0; i < kVectors; ++i) {
    here[i] = load(own + i * kFloats);
    sum[i] = Int{};
  }
  for (int k = 0; k < count; ++k) {
    const Float other = broadcast(depth[k]);
    for (int i = 0; i < kVectors; ++i) {
      sum[i] = select(less(other, here[i]), sum[i] + 1, sum[i]);
    }
  }
  for (int i = 0; i < kVectors; ++i) store(nearer + i * kFloats, sum[i]);
}

void count_all_nearer(const float* depth, int count, std::int32_t* nearer) {
  constexpr int kVectors = 4;
  int i = 0;
  for (; i + (kVectors - 1) * kFloats < count; i += kVectors * kFloats) {
    count_nearer<kVectors>(depth, count, depth + i, nearer + i);
  }
  for (; i < count; i += kFloats) count_nearer<1>(depth, count, depth + i, nearer + i);
}

constexpr SetupKernel kSetupKernel = {&cull, &set_up_boxes, &set_up_capsules, &set_up_cylinders,
                                      &count_all_nearer};

}  // namespace
}  // namespace engram::cpu
