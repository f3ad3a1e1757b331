// Projection of boxes, capsules and cylinders into a frame, eight at a time. Each number is the one
// that frame_builder_shapes.cc finds, which projects them one by one. Plain data only: this header
// is compiled for several instruction sets.
#pragma once

#include <cstdint>

#include "render/cpu/frame_data.h"

namespace engram::cpu {

inline constexpr int kBatch = 8;

template <typename T>
struct alignas(64) Lanes {
  T lane[kBatch];
};
using Doubles = Lanes<double>;
using Floats = Lanes<float>;
using Ints = Lanes<std::int32_t>;

// Camera and lights of a frame.
struct ViewParams {
  double rotation[3][3];  // from the world to the camera
  double eye[3];
  double near, half_u, half_v;
  double side_u, side_v;  // how far a ball of radius 1 reaches beyond the sides of the view
  int width, height;
  const float* u;
  const float* v;
  int light_count;
  double light[kMaxLights][3];  // unit, towards each, camera axes
  float light_color[kMaxLights][3];
  float ambient[3];
};

// Batch of geoms of one shape. Unused lanes hold copies of a used one.
struct GeomBatch {
  Doubles pose[12];
  Doubles size[3];
  Floats rgba[3];
  Floats emission;
};

// Results for each geom.
struct Visibility {
  // kSingle: the geom meets the near plane or a number is not finite; it must be projected alone.
  static constexpr std::int32_t kCulled = 0;
  static constexpr std::int32_t kVisible = 1;
  static constexpr std::int32_t kSingle = 2;
  Ints state;
  Ints x0, x1, y0, y1;
  Floats center_z;
};

struct Sides {
  Floats a, b, c;  // of an Affine
};

struct BoxSetup {
  Visibility visibility;
  Sides plane[6];
  Ints front[6];  // 1: the camera is in front of it
  Ints code[6];   // its colour
};

struct Conics {
  Floats u0, v0, bu, bv, b1, uu, uv, vv, u, v, one;
};

struct Forms {
  Floats a, b, c, d;
};

// The light on round surfaces: Surface's members.
struct RoundLight {
  Floats constant[3];
  Floats light[kMaxLights][3];
};

struct CapsuleSetup {
  Visibility visibility;
  Conics conic[3];
  Sides axis;
  Floats along;  // of the camera
  RoundLight lit;
  Forms toward[3][kMaxLights];  // side, ends
};

struct CylinderSetup {
  Visibility visibility;
  Conics side;
  Sides plane[2];  // of its caps
  Ints front_count;
  Ints within;  // the camera is inside the infinite cylinder
  RoundLight lit;
  Forms toward[kMaxLights];
  Ints code;  // of the cap in front
};

// Inner loops of the projection.
struct SetupKernel {
  // 1 for each ball of which something may be visible.
  void (*cull)(const ViewParams& camera, const Doubles (&position)[3], const Doubles& radius,
               Ints& visible);
  void (*boxes)(const ViewParams& camera, const GeomBatch& batch, BoxSetup& visibility);
  void (*capsules)(const ViewParams& camera, const GeomBatch& batch, CapsuleSetup& visibility);
  void (*cylinders)(const ViewParams& camera, const GeomBatch& batch, CylinderSetup& visibility);
  // Counts the depths that are less than each. Both arrays have room for whole blocks.
  void (*count_nearer)(const float* depth, int count, std::int32_t* nearer);
};

}  // namespace engram::cpu
