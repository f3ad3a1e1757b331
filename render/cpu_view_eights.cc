// Boxes, capsules and cylinders eight at a time, by the kernels of cpu_eights_body.h.
#include <algorithm>
#include <cmath>

#include "render/cpu_view.h"

namespace engram::cpu {
namespace {

bool has_eights(const RenderGeom& geom, RenderShape shape) {
  return geom.shape == shape &&
         (shape != RenderShape::kBox || geom.pattern == RenderPattern::kPlain);
}

// Calls use(first, count) for each eight.
template <typename Use>
void for_eights(std::size_t count, Use use) {
  for (std::size_t first = 0; first < count; first += kEight) {
    use(first, std::min<std::size_t>(kEight, count - first));
  }
}

Eight collect(const RenderScene& scene, const RenderInstances& instances,
              std::span<const int> geoms) {
  Eight eight;
  for (std::size_t lane = 0; lane < kEight; ++lane) {
    const auto geom = static_cast<std::size_t>(geoms[lane < geoms.size() ? lane : 0]);
    const float* pose = instances.geom_pose + 12 * geom;
    for (std::size_t i = 0; i < 12; ++i) eight.pose[i].lane[lane] = pose[i];
    for (std::size_t i = 0; i < 3; ++i) {
      eight.size[i].lane[lane] = scene.geoms[geom].size[i];
      eight.rgba[i].lane[lane] = instances.geom_rgba[4 * geom + i];
    }
    eight.emission.lane[lane] =
        instances.geom_emission == nullptr ? 0 : instances.geom_emission[geom];
  }
  return eight;
}

Affine take(const Sides& sides, std::size_t lane) {
  return {sides.a.lane[lane], sides.b.lane[lane], sides.c.lane[lane]};
}

Form take(const Forms& forms, std::size_t lane) {
  return {forms.a.lane[lane], forms.b.lane[lane], forms.c.lane[lane], forms.d.lane[lane]};
}

Conic take(const Conics& c, std::size_t lane) {
  return {c.u0.lane[lane], c.v0.lane[lane], c.bu.lane[lane], c.bv.lane[lane],
          c.b1.lane[lane], c.uu.lane[lane], c.uv.lane[lane], c.vv.lane[lane],
          c.u.lane[lane],  c.v.lane[lane],  c.one.lane[lane]};
}

}  // namespace

void View::add_eights(const RenderInstances& instances, Shown shown) {
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) lens_.rotation[i][k] = world_to_camera_(i, k);
    lens_.eye[i] = eye_[i];
    lens_.ambient[i] = prepared_->scene.ambient[i];
  }
  lens_.near = near_;
  lens_.half_u = half_u_;
  lens_.half_v = half_v_;
  lens_.side_u = std::sqrt(1 + half_u_ * half_u_);
  lens_.side_v = std::sqrt(1 + half_v_ * half_v_);
  lens_.width = width_;
  lens_.height = height_;
  lens_.u = u_.data();
  lens_.v = v_.data();
  lens_.light_count = frame_.light_count;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      lens_.light[i][k] = lights_[i][k];
      lens_.light_color[i][k] = prepared_->scene.lights[i].color[k];
    }
  }

  const std::vector<RenderGeom>& geoms = prepared_->scene.geoms;
  for (const auto& [shape, add_shape] : {std::pair{RenderShape::kBox, &View::add_boxes},
                                         std::pair{RenderShape::kCapsule, &View::add_capsules},
                                         std::pair{RenderShape::kCylinder, &View::add_cylinders}}) {
    const std::size_t count = find_waiting(instances, shown, shape);
    for_eights(count, [&, add = add_shape](std::size_t first, std::size_t size) {
      (this->*add)(instances, std::span<const int>(waiting_).subspan(first, size));
    });
  }
  for (std::size_t i = 0; i < geoms.size(); ++i) {
    const bool done = has_eights(geoms[i], RenderShape::kBox) ||
                      has_eights(geoms[i], RenderShape::kCapsule) ||
                      has_eights(geoms[i], RenderShape::kCylinder);
    if (!done && is_shown(instances, i, shown) && may_show(instances, i)) {
      add(place(instances, i), i);
    }
  }
}

// Puts the geoms of a shape that may be in sight into `waiting_`.
std::size_t View::find_waiting(const RenderInstances& instances, Shown shown, RenderShape shape) {
  const std::vector<RenderGeom>& geoms = prepared_->scene.geoms;
  std::size_t count = 0;
  for (std::size_t i = 0; i < geoms.size(); ++i) {
    waiting_[count] = static_cast<int>(i);
    count += has_eights(geoms[i], shape) && is_shown(instances, i, shown) ? 1 : 0;
  }
  std::size_t in_sight = 0;
  for_eights(count, [&](std::size_t first, std::size_t size) {
    Doubles position[3];
    Doubles radius;
    for (std::size_t lane = 0; lane < kEight; ++lane) {
      const auto geom = static_cast<std::size_t>(waiting_[first + (lane < size ? lane : 0)]);
      const float* from = instances.geom_pose + 12 * geom + 9;
      for (std::size_t k = 0; k < 3; ++k) position[k].lane[lane] = from[k];
      radius.lane[lane] = prepared_->ball_radius[geom];
    }
    Ints sight;
    eights_->cull(lens_, position, radius, sight);
    for (std::size_t lane = 0; lane < size; ++lane) {
      waiting_[in_sight] = waiting_[first + lane];
      in_sight += static_cast<std::size_t>(sight.lane[lane]);
    }
  });
  return in_sight;
}

Primitive& View::begin(PrimitiveKind kind, const Seen& seen, std::size_t lane) {
  Primitive& primitive = primitives_[static_cast<std::size_t>(primitive_count_)];
  primitive.kind = kind;
  primitive.rect = {seen.x0.lane[lane], seen.x1.lane[lane], seen.y0.lane[lane], seen.y1.lane[lane]};
  primitive.surface = surface_count_;
  primitive.planes = &planes_[plane_count_];
  return primitive;
}

Surface& View::add_colored(std::size_t geom, std::int32_t code) {
  const auto index = static_cast<std::size_t>(surface_count_++);
  Surface& surface = surfaces_[index];
  surface.lighting = Lighting::kConstant;
  surface.pattern = Pattern::kPlain;
  surface.gloss = -1;
  surface.segment = prepared_->scene.geoms[geom].segment;
  surface.packed = static_cast<std::uint32_t>(code);
  codes_[index] = surface.packed;
  return surface;
}

Surface& View::add_lit(std::size_t geom, const RoundLight& lit, std::size_t lane) {
  const auto index = static_cast<std::size_t>(surface_count_);
  Surface& surface = add_colored(geom, 0);
  surface.lighting = Lighting::kLinear;
  codes_[index] = kShaded | static_cast<std::uint32_t>(index);
  for (std::size_t k = 0; k < 3; ++k) {
    surface.constant[k] = lit.constant[k].lane[lane];
    for (std::size_t i = 0; i < lights_.size(); ++i) {
      surface.light[i][k] = lit.light[i][k].lane[lane];
    }
  }
  return surface;
}

void View::add_boxes(const RenderInstances& instances, std::span<const int> geoms) {
  SeenBoxes boxes;
  eights_->boxes(lens_, collect(prepared_->scene, instances, geoms), boxes);
  for (std::size_t lane = 0; lane < geoms.size(); ++lane) {
    const auto geom = static_cast<std::size_t>(geoms[lane]);
    if (boxes.seen.state.lane[lane] == Seen::kByItself) add(place(instances, geom), geom);
    if (boxes.seen.state.lane[lane] != Seen::kWhole) continue;
    Primitive& primitive = begin(PrimitiveKind::kConvex, boxes.seen, lane);
    Affine* fronts = &planes_[plane_count_];
    Affine* backs = fronts + 5;
    plane_count_ += 6;
    for (std::size_t face = 0; face < 6; ++face) {
      if (boxes.front[face].lane[lane] != 0) {
        *fronts++ = take(boxes.plane[face], lane);
        add_colored(geom, boxes.code[face].lane[lane]);
      } else {
        *backs-- = take(boxes.plane[face], lane);
      }
    }
    primitive.front_count = surface_count_ - primitive.surface;
    primitive.back_count = 6 - primitive.front_count;
    keep(primitive, boxes.seen.center_z.lane[lane] - prepared_->rank_radius[geom], geom);
  }
}

void View::add_capsules(const RenderInstances& instances, std::span<const int> geoms) {
  SeenCapsules capsules;
  eights_->capsules(lens_, collect(prepared_->scene, instances, geoms), capsules);
  for (std::size_t lane = 0; lane < geoms.size(); ++lane) {
    const auto geom = static_cast<std::size_t>(geoms[lane]);
    if (capsules.seen.state.lane[lane] == Seen::kByItself) add(place(instances, geom), geom);
    if (capsules.seen.state.lane[lane] != Seen::kWhole) continue;
    Primitive& primitive = begin(PrimitiveKind::kCapsule, capsules.seen, lane);
    for (std::size_t part = 0; part < 3; ++part) {
      primitive.conic[part] = take(capsules.conic[part], lane);
      Surface& surface = add_lit(geom, capsules.lit, lane);
      for (std::size_t i = 0; i < lights_.size(); ++i) {
        surface.toward[i] = take(capsules.toward[part][i], lane);
      }
    }
    primitive.local[0] = take(capsules.axis, lane);
    primitive.offset[0] = capsules.along.lane[lane];
    primitive.limit[0] = prepared_->scene.geoms[geom].size[1];
    keep(primitive, capsules.seen.center_z.lane[lane] - prepared_->rank_radius[geom], geom);
  }
}

void View::add_cylinders(const RenderInstances& instances, std::span<const int> geoms) {
  SeenCylinders cylinders;
  eights_->cylinders(lens_, collect(prepared_->scene, instances, geoms), cylinders);
  for (std::size_t lane = 0; lane < geoms.size(); ++lane) {
    const auto geom = static_cast<std::size_t>(geoms[lane]);
    if (cylinders.seen.state.lane[lane] == Seen::kByItself) add(place(instances, geom), geom);
    if (cylinders.seen.state.lane[lane] != Seen::kWhole) continue;
    Primitive& primitive = begin(PrimitiveKind::kCylinder, cylinders.seen, lane);
    for (std::size_t i = 0; i < 2; ++i) {
      planes_[plane_count_++] = take(cylinders.plane[i], lane);
    }
    primitive.conic[0] = take(cylinders.side, lane);
    primitive.front_count = cylinders.front_count.lane[lane];
    primitive.back_count = 2 - primitive.front_count;
    primitive.camera_within_side = cylinders.within.lane[lane] != 0;
    Surface& surface = add_lit(geom, cylinders.lit, lane);
    for (std::size_t i = 0; i < lights_.size(); ++i) {
      surface.toward[i] = take(cylinders.toward[i], lane);
    }
    if (primitive.front_count > 0) add_colored(geom, cylinders.code.lane[lane]);
    keep(primitive, cylinders.seen.center_z.lane[lane] - prepared_->rank_radius[geom], geom);
  }
}

}  // namespace engram::cpu
