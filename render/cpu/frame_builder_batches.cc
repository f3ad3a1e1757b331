// Boxes, capsules and cylinders in batches, by the kernels of geom_batch_body.h.
#include <algorithm>
#include <cmath>

#include "render/cpu/frame_builder.h"

namespace engram::cpu {
namespace {

// Calls use(first, count) for each batch.
template <typename Use>
void for_batches(std::size_t count, Use use) {
  for (std::size_t first = 0; first < count; first += kBatch) {
    use(first, std::min<std::size_t>(kBatch, count - first));
  }
}

GeomBatch collect(const RenderScene& scene, const RenderInstances& instances,
                  std::span<const int> geoms) {
  GeomBatch batch;
  for (std::size_t lane = 0; lane < kBatch; ++lane) {
    const auto geom = static_cast<std::size_t>(geoms[lane < geoms.size() ? lane : 0]);
    const float* pose = instances.geom_pose + 12 * geom;
    for (std::size_t i = 0; i < 12; ++i) batch.pose[i].lane[lane] = pose[i];
    for (std::size_t i = 0; i < 3; ++i) {
      batch.size[i].lane[lane] = scene.geoms[geom].size[i];
      batch.rgba[i].lane[lane] = instances.geom_rgba[4 * geom + i];
    }
    batch.emission.lane[lane] =
        instances.geom_emission == nullptr ? 0 : instances.geom_emission[geom];
  }
  return batch;
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

void FrameBuilder::add_batches(const RenderInstances& instances, Shown shown) {
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) view_params_.rotation[i][k] = world_to_camera_(i, k);
    view_params_.eye[i] = eye_[i];
    view_params_.ambient[i] = ambient_[i];
  }
  view_params_.near = near_;
  view_params_.half_u = half_u_;
  view_params_.half_v = half_v_;
  view_params_.side_u = std::sqrt(1 + half_u_ * half_u_);
  view_params_.side_v = std::sqrt(1 + half_v_ * half_v_);
  view_params_.width = width_;
  view_params_.height = height_;
  view_params_.u = u_.data();
  view_params_.v = v_.data();
  view_params_.light_count = frame_.light_count;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      view_params_.light[i][k] = lights_[i][k];
      view_params_.light_color[i][k] = light_colors_[i].color[k];
    }
  }

  const auto add_shape = [&](const std::vector<int>& geoms, auto add_batch) {
    const std::size_t count = find_pending(instances, shown, geoms);
    for_batches(count, [&](std::size_t first, std::size_t size) {
      (this->*add_batch)(instances, std::span<const int>(pending_).subspan(first, size));
    });
  };
  add_shape(prepared_->boxes, &FrameBuilder::add_boxes);
  add_shape(prepared_->capsules, &FrameBuilder::add_capsules);
  add_shape(prepared_->cylinders, &FrameBuilder::add_cylinders);
  for (const int geom : prepared_->others) {
    const auto i = static_cast<std::size_t>(geom);
    if (is_shown(instances, i, shown) && may_show(instances, i)) add(place(instances, i), i);
  }
}

// Puts those of some geoms that may be visible into `pending_`.
std::size_t FrameBuilder::find_pending(const RenderInstances& instances, Shown shown,
                                       std::span<const int> geoms) {
  std::size_t count = 0;
  for (const int geom : geoms) {
    pending_[count] = geom;
    count += is_shown(instances, static_cast<std::size_t>(geom), shown) ? 1 : 0;
  }
  std::size_t in_sight = 0;
  for_batches(count, [&](std::size_t first, std::size_t size) {
    Doubles position[3];
    Doubles radius;
    for (std::size_t lane = 0; lane < kBatch; ++lane) {
      const auto geom = static_cast<std::size_t>(pending_[first + (lane < size ? lane : 0)]);
      const float* from = instances.geom_pose + 12 * geom + 9;
      for (std::size_t k = 0; k < 3; ++k) position[k].lane[lane] = from[k];
      radius.lane[lane] = prepared_->ball_radius[geom];
    }
    Ints visible;
    setup_->cull(view_params_, position, radius, visible);
    for (std::size_t lane = 0; lane < size; ++lane) {
      pending_[in_sight] = pending_[first + lane];
      in_sight += static_cast<std::size_t>(visible.lane[lane]);
    }
  });
  return in_sight;
}

ScreenPrimitive& FrameBuilder::begin(PrimitiveKind kind, const Visibility& visibility,
                                     std::size_t lane) {
  ScreenPrimitive& primitive = primitives_[static_cast<std::size_t>(primitive_count_)];
  primitive.kind = kind;
  primitive.rect = {visibility.x0.lane[lane], visibility.x1.lane[lane], visibility.y0.lane[lane],
                    visibility.y1.lane[lane]};
  primitive.surface = surface_count_;
  primitive.planes = &planes_[plane_count_];
  return primitive;
}

void FrameBuilder::add_colored(std::size_t geom, std::uint32_t code) {
  const auto index = static_cast<std::size_t>(surface_count_++);
  codes_[index] = code;
  segments_[index] = static_cast<std::uint32_t>(prepared_->scene.geoms[geom].segment);
}

Surface& FrameBuilder::add_lit(std::size_t geom, const RoundLight& lit, std::size_t lane) {
  const auto index = static_cast<std::size_t>(surface_count_);
  add_colored(geom, kShaded | static_cast<std::uint32_t>(index));
  Surface& surface = surfaces_[index];
  surface.lighting = Lighting::kLinear;
  surface.pattern = Pattern::kPlain;
  surface.gloss = -1;
  for (std::size_t k = 0; k < 3; ++k) {
    surface.constant[k] = lit.constant[k].lane[lane];
    for (std::size_t i = 0; i < lights_.size(); ++i) {
      surface.light[i][k] = lit.light[i][k].lane[lane];
    }
  }
  return surface;
}

void FrameBuilder::add_boxes(const RenderInstances& instances, std::span<const int> geoms) {
  BoxSetup boxes;
  setup_->boxes(view_params_, collect(prepared_->scene, instances, geoms), boxes);
  for (std::size_t lane = 0; lane < geoms.size(); ++lane) {
    const auto geom = static_cast<std::size_t>(geoms[lane]);
    if (boxes.visibility.state.lane[lane] == Visibility::kSingle) add(place(instances, geom), geom);
    if (boxes.visibility.state.lane[lane] != Visibility::kVisible) continue;
    ScreenPrimitive& primitive = begin(PrimitiveKind::kConvex, boxes.visibility, lane);
    // Fronts from the first place on, the others from the last; without branches, as it is not to
    // be predicted which is which.
    std::size_t fronts = 0;
    for (std::size_t face = 0; face < 6; ++face) {
      const bool front = boxes.front[face].lane[lane] != 0;
      planes_[plane_count_ + (front ? fronts : 5 - (face - fronts))] =
          take(boxes.plane[face], lane);
      const std::size_t surface = static_cast<std::size_t>(surface_count_) + fronts;
      codes_[surface] = static_cast<std::uint32_t>(boxes.code[face].lane[lane]);
      segments_[surface] = static_cast<std::uint32_t>(prepared_->scene.geoms[geom].segment);
      fronts += front ? 1 : 0;
    }
    plane_count_ += 6;
    surface_count_ += static_cast<int>(fronts);
    primitive.front_count = static_cast<int>(fronts);
    primitive.back_count = 6 - primitive.front_count;
    keep(primitive, false, boxes.visibility.center_z.lane[lane] - prepared_->rank_radius[geom],
         geom);
  }
}

void FrameBuilder::add_capsules(const RenderInstances& instances, std::span<const int> geoms) {
  CapsuleSetup capsules;
  setup_->capsules(view_params_, collect(prepared_->scene, instances, geoms), capsules);
  for (std::size_t lane = 0; lane < geoms.size(); ++lane) {
    const auto geom = static_cast<std::size_t>(geoms[lane]);
    if (capsules.visibility.state.lane[lane] == Visibility::kSingle)
      add(place(instances, geom), geom);
    if (capsules.visibility.state.lane[lane] != Visibility::kVisible) continue;
    ScreenPrimitive& primitive = begin(PrimitiveKind::kCapsule, capsules.visibility, lane);
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
    keep(primitive, true, capsules.visibility.center_z.lane[lane] - prepared_->rank_radius[geom],
         geom);
  }
}

void FrameBuilder::add_cylinders(const RenderInstances& instances, std::span<const int> geoms) {
  CylinderSetup cylinders;
  setup_->cylinders(view_params_, collect(prepared_->scene, instances, geoms), cylinders);
  for (std::size_t lane = 0; lane < geoms.size(); ++lane) {
    const auto geom = static_cast<std::size_t>(geoms[lane]);
    if (cylinders.visibility.state.lane[lane] == Visibility::kSingle)
      add(place(instances, geom), geom);
    if (cylinders.visibility.state.lane[lane] != Visibility::kVisible) continue;
    ScreenPrimitive& primitive = begin(PrimitiveKind::kCylinder, cylinders.visibility, lane);
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
    if (primitive.front_count > 0) {
      add_colored(geom, static_cast<std::uint32_t>(cylinders.code.lane[lane]));
    }
    keep(primitive, true, cylinders.visibility.center_z.lane[lane] - prepared_->rank_radius[geom],
         geom);
  }
}

}  // namespace engram::cpu
