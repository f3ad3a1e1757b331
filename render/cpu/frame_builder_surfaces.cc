// Reflection of light by surfaces.
#include <algorithm>
#include <cmath>

#include "render/cpu/frame_builder.h"

namespace engram::cpu {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// f . (p - origin) for the visible point p.
Form form_of(const Vector3d& f, const Vector3d& origin) {
  return {static_cast<float>(f.x()), static_cast<float>(f.y()), static_cast<float>(f.z()),
          static_cast<float>(-f.dot(origin))};
}

Pattern pattern_of(RenderPattern pattern) {
  switch (pattern) {
    case RenderPattern::kPlain:
      return Pattern::kPlain;
    case RenderPattern::kWood:
      return Pattern::kWood;
    case RenderPattern::kGrid:
      return Pattern::kGrid;
  }
  return Pattern::kPlain;
}

}  // namespace

Surface& FrameBuilder::new_surface(const PlacedGeom& placed) {
  const auto index = static_cast<std::size_t>(surface_count_++);
  segments_[index] = static_cast<std::uint32_t>(placed.geom->segment);
  Surface& surface = surfaces_[index];
  surface.pattern = Pattern::kPlain;
  surface.gloss = -1;
  for (int k = 0; k < 3; ++k) {
    const float color = placed.rgba[k] * 255;
    surface.constant[k] = color * (ambient_[k] + placed.emission);
    for (std::size_t i = 0; i < lights_.size(); ++i) {
      surface.light[i][k] = color * light_colors_[i].color[k];
    }
  }
  return surface;
}

// Without shadows a flat surface has one brightness.
void FrameBuilder::light_flat(const Vector3d& normal, Surface& surface) const {
  surface.lighting = frame_.shadows ? Lighting::kLinear : Lighting::kConstant;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const auto amount = static_cast<float>(std::max(normal.dot(lights_[i]), 0.0));
    if (frame_.shadows) {
      surface.toward[i] = {0, 0, 0, amount};
      continue;
    }
    for (int k = 0; k < 3; ++k) surface.constant[k] += surface.light[i][k] * amount;
  }
}

void FrameBuilder::add_flat(const PlacedGeom& placed, const Vector3d& normal) {
  light_flat(normal, new_surface(placed));
}

void FrameBuilder::add_patterned(const PlacedGeom& placed, const Vector3d& normal,
                                 const Affine& plane, int along, int across) {
  Surface& surface = new_surface(placed);
  light_flat(normal, surface);
  RenderSurface shown{placed.geom->pattern};
  if (placed.surface != nullptr) shown = *placed.surface;
  surface.pattern = pattern_of(shown.pattern);
  if (shown.turned) std::swap(along, across);
  if (surface.pattern == Pattern::kWood) surface.gloss = add_gloss(normal);
  surface.plane = plane;
  surface.axes[0] = form_of(shown.scale * placed.axes.col(along), placed.center);
  surface.axes[1] = form_of(shown.scale * placed.axes.col(across), placed.center);
  for (int i = 0; i < 2; ++i) {
    const Form& form = surface.axes[i];
    surface.spread[i][0] = form.a * plane.b - form.b * plane.a;
    surface.spread[i][1] = form.a * plane.c - form.c * plane.a;
    surface.spread[i][2] = form.b * plane.c - form.c * plane.b;
  }
}

int FrameBuilder::add_gloss(const Vector3d& normal) {
  Gloss& gloss = glosses_[static_cast<std::size_t>(frame_.gloss_count)];
  for (int k = 0; k < 3; ++k) gloss.normal[k] = static_cast<float>(normal[k]);
  gloss.light_count = 0;
  for (const Vector3d& light : lights_) {
    const double facing = normal.dot(light);
    if (facing <= 0) continue;
    const int i = gloss.light_count++;
    for (int k = 0; k < 3; ++k) gloss.light[i][k] = static_cast<float>(light[k]);
    gloss.facing[i] = static_cast<float>(facing);
  }
  return frame_.gloss_count++;
}

// Surfaces whose normal is an affine function of the point: normal_of (p - center).
void FrameBuilder::add_round(const PlacedGeom& placed, const Matrix3d& normal_of,
                             const Vector3d& center) {
  Surface& surface = new_surface(placed);
  surface.lighting = Lighting::kLinear;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    surface.toward[i] = form_of(normal_of * lights_[i], center);
  }
}

void FrameBuilder::add_ellipsoid(const PlacedGeom& placed, const Matrix3d& form) {
  Surface& surface = new_surface(placed);
  surface.lighting = Lighting::kEllipsoid;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    surface.toward[i] = form_of(form * lights_[i], placed.center);
  }
  for (int k = 0; k < 3; ++k) surface.axes[k] = form_of(form.col(k), placed.center);
}

const FrameData& FrameBuilder::segmented() {
  segmented_ = frame_;
  segmented_.codes = segments_.data();
  segmented_.shades = false;
  return segmented_;
}

}  // namespace engram::cpu
