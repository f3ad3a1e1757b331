// Kernel: set-up of boxes, capsules and cylinders, eight at a time. Included by cpu_kernel_*.cc
// only. Sums are in the order in which Eigen has them, so that every number comes out as
// cpu_view_shapes.cc has it.
#pragma once

#include "render/cpu_eights.h"
#include "render/cpu_simd_double.h"

namespace engram::cpu {
namespace {

struct Three {
  Double at[3];
};

ENGRAM_INLINE Three three(const double* from) {
  return {splat_double(from[0]), splat_double(from[1]), splat_double(from[2])};
}
ENGRAM_INLINE Double dot(const Three& a, const Three& b) {
  return a.at[0] * b.at[0] + a.at[1] * b.at[1] + a.at[2] * b.at[2];
}
ENGRAM_INLINE Three scaled(const Three& a, Double by) {
  return {a.at[0] * by, a.at[1] * by, a.at[2] * by};
}
ENGRAM_INLINE Three plus(const Three& a, const Three& b) {
  return {a.at[0] + b.at[0], a.at[1] + b.at[1], a.at[2] + b.at[2]};
}
ENGRAM_INLINE Three minus(const Three& a, const Three& b) {
  return {a.at[0] - b.at[0], a.at[1] - b.at[1], a.at[2] - b.at[2]};
}

// By rows.
struct Matrix {
  Three row[3];
};

ENGRAM_INLINE Three column(const Matrix& m, int i) {
  return {m.row[0].at[i], m.row[1].at[i], m.row[2].at[i]};
}
// The last row's sum begins at its end.
ENGRAM_INLINE Three product(const Matrix& m, const Three& a) {
  const Three& last = m.row[2];
  return {dot(m.row[0], a), dot(m.row[1], a),
          last.at[0] * a.at[0] + (last.at[1] * a.at[1] + last.at[2] * a.at[2])};
}

// Where geoms are in camera axes.
struct PlacedEight {
  Three center;
  Matrix axes;
  Double finite;  // 0, or not a number

  ENGRAM_INLINE PlacedEight(const Lens& lens, const Eight& eight, int at) {
    const auto value = [&](int i) __attribute__((always_inline)) {
      return load(eight.pose[i].lane + at);
    };
    const Matrix turn = {three(lens.rotation[0]), three(lens.rotation[1]), three(lens.rotation[2])};
    center = product(turn, minus({value(9), value(10), value(11)}, three(lens.eye)));
    finite = (center.at[0] + center.at[1] + center.at[2]) * 0.0;
    for (int i = 0; i < 3; ++i) {
      const Three axis = product(turn, {value(i), value(3 + i), value(6 + i)});
      for (int k = 0; k < 3; ++k) {
        axes.row[k].at[i] = axis.at[k];
        finite += axis.at[k] * 0.0;
      }
    }
  }
};

// Ranges of u and v, and whether the near plane spoils them.
struct Extents {
  Double low[2] = {splat_double(1e30), splat_double(1e30)};
  Double high[2] = {splat_double(-1e30), splat_double(-1e30)};
  Double spoilt = {};

  ENGRAM_INLINE void include(int k, Double from, Double to) {
    low[k] = min_of(low[k], from);
    high[k] = max_of(high[k], to);
  }
};

// Rectangles in pixels, whole numbers; as View::to_pixels().
struct Rects {
  Double x0, x1, y0, y1;
  Double empty;

  ENGRAM_INLINE Rects(const Lens& lens, const Extents& extents) {
    constexpr double kMargin = 0.25;
    const double columns = 0.5 * lens.width / lens.half_u;
    const double rows = 0.5 * lens.height / lens.half_v;
    const double column = 0.5 * lens.width - 0.5;
    const double row = 0.5 * lens.height - 0.5;
    const auto first = [](Double value, int size) __attribute__((always_inline)) {
      return round_up(clamp_to(value - kMargin, 0.0, size));
    };
    const auto last = [](Double value, int size) __attribute__((always_inline)) {
      return round_down(clamp_to(value + kMargin, -1.0, size - 1.0)) + 1.0;
    };
    x0 = first(extents.low[0] * columns + column, lens.width);
    x1 = last(extents.high[0] * columns + column, lens.width);
    y0 = first(row - extents.high[1] * rows, lens.height);
    y1 = last(row - extents.low[1] * rows, lens.height);
    const auto none = (x0 >= x1) | (y0 >= y1);
    empty = none ? splat_double(1) : Double{};
  }
};

ENGRAM_INLINE void store_seen(const PlacedEight& placed, const Extents& extents, const Rects& rects,
                              Double unseen, int at, Seen& out) {
  Double state = splat_double(Seen::kWhole);
  state = rects.empty + unseen > 0.0 ? splat_double(Seen::kNothing) : state;
  const auto good = (extents.spoilt == 0.0) & (placed.finite == 0.0);
  state = good ? state : splat_double(Seen::kByItself);
  store(out.state.lane + at, state);
  store(out.x0.lane + at, rects.x0);
  store(out.x1.lane + at, rects.x1);
  store(out.y0.lane + at, rects.y0);
  store(out.y1.lane + at, rects.y1);
  store(out.center_z.lane + at, placed.center.at[2]);
}

ENGRAM_INLINE Double plane_divisor(Double distance) {
  return magnitude(distance) < 1e-7 ? splat_double(1e-7) : distance;
}

ENGRAM_INLINE void store_sides(const Three& f, int at, Sides& out) {
  store(out.a.lane + at, f.at[0]);
  store(out.b.lane + at, f.at[1]);
  store(out.c.lane + at, f.at[2]);
}

ENGRAM_INLINE void store_bound(const Three& normal, Double distance, int at, Sides& out) {
  const Double by = plane_divisor(distance);
  store_sides({normal.at[0] / by, normal.at[1] / by, normal.at[2] / by}, at, out);
}

// Colours of lights and surfaces: plain loops over lanes, which compilers turn into vectors.
ENGRAM_INLINE void light_round(const Lens& lens, const Eight& eight, RoundLight& out) {
  for (int k = 0; k < 3; ++k) {
    Floats color;
    for (int i = 0; i < kEight; ++i) color.lane[i] = eight.rgba[k].lane[i] * 255;
    for (int i = 0; i < kEight; ++i) {
      out.constant[k].lane[i] = color.lane[i] * (lens.ambient[k] + eight.emission.lane[i]);
    }
    for (int light = 0; light < lens.light_count; ++light) {
      for (int i = 0; i < kEight; ++i) {
        out.light[light][k].lane[i] = color.lane[i] * lens.light_color[light][k];
      }
    }
  }
}

// Of flat surfaces, as View::light_flat(). `amount`: of each light.
ENGRAM_INLINE void light_flat(const Lens& lens, const RoundLight& lit,
                              const Floats (&amount)[kMaxLights], Ints& code) {
  constexpr float kRound = 12582912.0F;  // 1.5 * 2^23: no bits are left for a fraction
  for (int i = 0; i < kEight; ++i) code.lane[i] = 0;
  for (int k = 0; k < 3; ++k) {
    Floats level = lit.constant[k];
    for (int light = 0; light < lens.light_count; ++light) {
      for (int i = 0; i < kEight; ++i) {
        level.lane[i] += lit.light[light][k].lane[i] * amount[light].lane[i];
      }
    }
    for (int i = 0; i < kEight; ++i) {
      float value = level.lane[i];
      value = value < 0.0F ? 0.0F : value;
      value = value > 255.0F ? 255.0F : value;
      code.lane[i] |= static_cast<std::int32_t>((value + kRound) - kRound) << (8 * k);
    }
  }
}

ENGRAM_INLINE void store_amounts(const Lens& lens, const Three& normal, int at,
                                 Floats (&amount)[kMaxLights]) {
  for (int light = 0; light < lens.light_count; ++light) {
    store(amount[light].lane + at, max_of(dot(normal, three(lens.light[light])), Double{}));
  }
}

void cull(const Lens& lens, const Doubles (&position)[3], const Doubles& radius, Ints& sight) {
  for (int at = 0; at < kEight; at += kDoubles) {
    const Matrix turn = {three(lens.rotation[0]), three(lens.rotation[1]), three(lens.rotation[2])};
    const Three center =
        product(turn, minus({load(position[0].lane + at), load(position[1].lane + at),
                             load(position[2].lane + at)},
                            three(lens.eye)));
    const Double r = load(radius.lane + at);
    const auto out = (center.at[2] + r < lens.near) |
                     (magnitude(center.at[0]) - lens.half_u * center.at[2] > r * lens.side_u) |
                     (magnitude(center.at[1]) - lens.half_v * center.at[2] > r * lens.side_v);
    store(sight.lane + at, out ? Double{} : splat_double(1));
  }
}

void set_up_boxes(const Lens& lens, const Eight& eight, SeenBoxes& out) {
  Floats amount[6][kMaxLights];
  for (int at = 0; at < kEight; at += kDoubles) {
    const PlacedEight placed(lens, eight, at);
    Double half[3];
    Three half_axes[3];
    for (int i = 0; i < 3; ++i) {
      half[i] = load(eight.size[i].lane + at);
      half_axes[i] = scaled(column(placed.axes, i), half[i]);
    }
    Extents extents;
    for (int corner = 0; corner < 8; ++corner) {
      Double sides[3][3];
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
          sides[i][k] = (corner >> i & 1) != 0 ? half_axes[i].at[k] : -half_axes[i].at[k];
        }
      }
      Three p;
      p.at[0] = placed.center.at[0] + (sides[0][0] + sides[1][0] + sides[2][0]);
      p.at[1] = placed.center.at[1] + (sides[0][1] + sides[1][1] + sides[2][1]);
      p.at[2] = placed.center.at[2] + (sides[0][2] + (sides[1][2] + sides[2][2]));
      extents.spoilt += p.at[2] >= lens.near ? Double{} : splat_double(1);
      const Double nearness = 1.0 / p.at[2];
      for (int k = 0; k < 2; ++k) extents.include(k, p.at[k] * nearness, p.at[k] * nearness);
    }
    Double behind = splat_double(1);  // every face
    for (int face = 0; face < 6; ++face) {
      const int axis = face / 2;
      const double sign = face % 2 == 0 ? 1.0 : -1.0;
      const Three direction = column(placed.axes, axis);
      const Three normal = scaled(direction, splat_double(sign));
      const Double distance = sign * dot(direction, placed.center) + half[axis];
      const Double front = distance <= -1e-7 ? splat_double(1) : Double{};
      behind = front > 0.0 ? Double{} : behind;
      store(out.front[face].lane + at, front);
      store_bound(normal, distance, at, out.plane[face]);
      store_amounts(lens, normal, at, amount[face]);
    }
    store_seen(placed, extents, Rects(lens, extents), behind, at, out.seen);
  }
  RoundLight lit;
  light_round(lens, eight, lit);
  for (int face = 0; face < 6; ++face) light_flat(lens, lit, amount[face], out.code[face]);
}

// Adds a ball's outline to the extents, as View::include_ball(). Of its half axes' products with
// themselves, `square` has xx, yy, zz and `with_z` xz, yz.
ENGRAM_INLINE void include_ball(const Lens& lens, const Three& center, const Three& square,
                                const Double (&with_z)[2], Extents& extents) {
  const Double z = center.at[2];
  extents.spoilt += z - square_root(square.at[2]) <= lens.near ? splat_double(1) : Double{};
  const Double a = z * z - square.at[2];
  for (int k = 0; k < 2; ++k) {
    const Double b = center.at[k] * z - with_z[k];
    const Double c = center.at[k] * center.at[k] - square.at[k];
    const Double root = square_root(max_of(b * b - a * c, Double{}));
    extents.include(k, (b - root) / a, (b + root) / a);
  }
}

// The same for a ball, or a disc without `third`.
struct HalfAxes {
  Three square;
  Double with_z[2];

  ENGRAM_INLINE HalfAxes(const Matrix& axes, Double radius, bool third) {
    Three h[3];
    for (int k = 0; k < 3; ++k) {
      h[k] = scaled(axes.row[k], radius);
      if (!third) h[k].at[2] = Double{};
    }
    const Three& z = h[2];
    square = {dot(h[0], h[0]), dot(h[1], h[1]),
              z.at[0] * z.at[0] + (z.at[1] * z.at[1] + z.at[2] * z.at[2])};
    with_z[0] = dot(h[0], z);
    with_z[1] = dot(h[1], z);
  }
};

// The middles of rectangles, as rays.
ENGRAM_INLINE Three middle_of(const Lens& lens, const Rects& rects) {
  alignas(64) double u[kDoubles];
  alignas(64) double v[kDoubles];
  alignas(64) std::int32_t x[kDoubles];
  alignas(64) std::int32_t y[kDoubles];
  // Rectangles of what is not seen may be anything.
  const auto within = [](Double at, int size) __attribute__((always_inline)) {
    return ((at >= 0.0) & (at < size)) ? at : Double{};
  };
  store(x, within((rects.x0 + rects.x1) * 0.5, lens.width));
  store(y, within((rects.y0 + rects.y1) * 0.5, lens.height));
  for (int i = 0; i < kDoubles; ++i) {
    u[i] = lens.u[x[i]];
    v[i] = lens.v[y[i]];
  }
  return {load(u), load(v), splat_double(1)};
}

// As View::make_conic(). Lanes where `none` is not 0 get a conic that no ray meets.
ENGRAM_INLINE void store_conic(const Matrix& form, const Three& g, const Three& center,
                               Double level, const Three& middle, Double none, int at,
                               Conics& out) {
  Double c = dot(center, g) - level;
  const Double least = 1e-9 * level;
  c = magnitude(c) < least ? least : c;
  const Double square = c * c;
  Matrix q;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      q.row[i].at[k] = (g.at[i] * g.at[k] - c * form.row[i].at[k]) / square;
    }
  }
  Matrix twice;
  for (int i = 0; i < 3; ++i) twice.row[i] = scaled(q.row[i], splat_double(2));
  const Three slope = product(twice, middle);
  const auto keep = [&](Floats & to, Double value) __attribute__((always_inline)) {
    store(to.lane + at, none == 0.0 ? value : Double{});
  };
  keep(out.u0, middle.at[0]);
  keep(out.v0, middle.at[1]);
  keep(out.bu, g.at[0] / c);
  keep(out.bv, g.at[1] / c);
  keep(out.b1, dot(g, middle) / c);
  keep(out.uu, q.row[0].at[0]);
  keep(out.uv, 2.0 * q.row[0].at[1]);
  keep(out.vv, q.row[1].at[1]);
  keep(out.u, slope.at[0]);
  keep(out.v, slope.at[1]);
  const Double one = 0.5 * dot(slope, middle);
  store(out.one.lane + at, none == 0.0 ? one : splat_double(-1));
}

ENGRAM_INLINE void store_form(const Three& f, const Three& origin, int at, Forms& out) {
  store(out.a.lane + at, f.at[0]);
  store(out.b.lane + at, f.at[1]);
  store(out.c.lane + at, f.at[2]);
  store(out.d.lane + at, -dot(f, origin));
}

// What is left of a vector across an axis.
ENGRAM_INLINE Matrix across_of(const Three& axis) {
  Matrix across;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      across.row[i].at[k] = (i == k ? 1.0 : 0.0) - axis.at[i] * axis.at[k];
    }
  }
  return across;
}

ENGRAM_INLINE Matrix divided(const Matrix& m, Double by) {
  Matrix result;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) result.row[i].at[k] = m.row[i].at[k] / by;
  }
  return result;
}

ENGRAM_INLINE Matrix identity() {
  Matrix m = {};
  for (int i = 0; i < 3; ++i) m.row[i].at[i] = splat_double(1);
  return m;
}

void set_up_capsules(const Lens& lens, const Eight& eight, SeenCapsules& out) {
  for (int at = 0; at < kEight; at += kDoubles) {
    const PlacedEight placed(lens, eight, at);
    const Double radius = load(eight.size[0].lane + at);
    const Double half_length = load(eight.size[1].lane + at);
    const Three axis = column(placed.axes, 2);
    const Three reach = scaled(axis, half_length);
    const Three ends[2] = {plus(placed.center, reach), minus(placed.center, reach)};
    const Matrix across = across_of(axis);
    const HalfAxes ball(placed.axes, radius, true);
    Extents extents;
    for (const Three& end : ends) include_ball(lens, end, ball.square, ball.with_z, extents);
    const Rects rects(lens, extents);

    const Double along = -dot(axis, placed.center);
    const Double nearest = min_of(max_of(along, -half_length), half_length);
    const Three gap = plus(placed.center, scaled(axis, nearest));
    const Double inside = square_root(dot(gap, gap)) <= radius ? splat_double(1) : Double{};
    const Three off_axis = product(across, placed.center);
    const Double end_only =
        square_root(dot(off_axis, off_axis)) <= radius ? splat_double(1) : Double{};
    store_seen(placed, extents, rects, inside, at, out.seen);

    const Three middle = middle_of(lens, rects);
    const Double level = radius * radius;
    store_conic(across, off_axis, placed.center, level, middle, end_only, at, out.conic[0]);
    for (int i = 0; i < 2; ++i) {
      store_conic(identity(), ends[i], ends[i], level, middle, Double{}, at, out.conic[i + 1]);
    }
    store_sides(axis, at, out.axis);
    store(out.along.lane + at, along);
    const Matrix side_normal = divided(across, radius);
    const Matrix end_normal = divided(identity(), radius);
    for (int light = 0; light < lens.light_count; ++light) {
      const Three toward = three(lens.light[light]);
      store_form(product(side_normal, toward), placed.center, at, out.toward[0][light]);
      const Three f = product(end_normal, toward);
      for (int i = 0; i < 2; ++i) store_form(f, ends[i], at, out.toward[i + 1][light]);
    }
  }
  light_round(lens, eight, out.lit);
}

void set_up_cylinders(const Lens& lens, const Eight& eight, SeenCylinders& out) {
  Floats amount[kMaxLights];
  for (int at = 0; at < kEight; at += kDoubles) {
    const PlacedEight placed(lens, eight, at);
    const Double radius = load(eight.size[0].lane + at);
    const Double half_length = load(eight.size[1].lane + at);
    const Three axis = column(placed.axes, 2);
    const Three reach = scaled(axis, half_length);
    const Matrix across = across_of(axis);
    const HalfAxes disc(placed.axes, radius, false);
    Extents extents;
    include_ball(lens, plus(placed.center, reach), disc.square, disc.with_z, extents);
    include_ball(lens, minus(placed.center, reach), disc.square, disc.with_z, extents);
    const Rects rects(lens, extents);

    // Caps: at most one faces the camera; it comes first.
    const Double middle_height = dot(axis, placed.center);
    const Double top = middle_height + half_length;
    const Double bottom = half_length - middle_height;
    const auto from_above = top <= -1e-7;
    const auto from_below = bottom <= -1e-7;
    const Double has_front = (from_above | from_below) ? splat_double(1) : Double{};
    const Double top_divisor = plane_divisor(top);
    const Double bottom_divisor = plane_divisor(bottom);
    Three planes[2];
    Three front_normal;
    for (int k = 0; k < 3; ++k) {
      const Double of_top = axis.at[k] / top_divisor;
      const Double of_bottom = -axis.at[k] / bottom_divisor;
      planes[0].at[k] = from_below ? of_bottom : of_top;
      planes[1].at[k] = from_below ? of_top : of_bottom;
      front_normal.at[k] = from_above ? axis.at[k] : -axis.at[k];
    }
    for (int i = 0; i < 2; ++i) store_sides(planes[i], at, out.plane[i]);
    store(out.front_count.lane + at, has_front);
    store_amounts(lens, front_normal, at, amount);

    const Three off_axis = product(across, placed.center);
    const Double level = radius * radius;
    const auto is_within = dot(off_axis, off_axis) - level < 1e-9 * radius * radius;
    const Double within = is_within ? splat_double(1) : Double{};
    store(out.within.lane + at, within);
    store_seen(placed, extents, rects, within > has_front ? splat_double(1) : Double{}, at,
               out.seen);
    store_conic(across, off_axis, placed.center, level, middle_of(lens, rects), Double{}, at,
                out.side);
    const Matrix normal = divided(across, radius);
    for (int light = 0; light < lens.light_count; ++light) {
      store_form(product(normal, three(lens.light[light])), placed.center, at, out.toward[light]);
    }
  }
  light_round(lens, eight, out.lit);
  light_flat(lens, out.lit, amount, out.code);
}

void count_nearer(const float* depth, const float* number, int count, std::int32_t* nearer) {
  for (int i = 0; i < count; i += kLanes) {
    const Float own_depth = load(depth + i);
    const Float own_number = load(number + i);
    Int sum = Int{};
    for (int k = 0; k < count; ++k) {
      const Float other = splat(depth[k]);
      const Mask before =
          less(other, own_depth) | (at_most(other, own_depth) & less(splat(number[k]), own_number));
      sum = select(before, sum + 1, sum);
    }
    store(nearer + i, sum);
  }
}

constexpr EightsKernel kEights = {&cull, &set_up_boxes, &set_up_capsules, &set_up_cylinders,
                                  &count_nearer};

}  // namespace
}  // namespace engram::cpu
