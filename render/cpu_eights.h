// Boxes, capsules and cylinders on their way into a frame, eight at a time. Each number is the one
// that cpu_view_shapes.cc finds, which takes them one by one. Plain data only: this header is
// compiled for several instruction sets.
#pragma once

#include <cstdint>

#include "render/cpu_frame.h"

namespace engram::cpu {

inline constexpr int kEight = 8;

template <typename T>
struct alignas(64) Lanes {
  T lane[kEight];
};
using Doubles = Lanes<double>;
using Floats = Lanes<float>;
using Ints = Lanes<std::int32_t>;

// What a view and its lights are to the set-up.
struct Lens {
  double rotation[3][3];  // from the world to the camera
  double eye[3];
  double near, half_u, half_v;
  double side_u, side_v;  // how far a ball of radius 1 reaches beyond the sides of what is seen
  int width, height;
  const float* u;
  const float* v;
  int light_count;
  double light[kMaxLights][3];  // unit, towards each, camera axes
  float light_color[kMaxLights][3];
  float ambient[3];
};

// Eight geoms of one shape. Unused lanes hold copies of a used one.
struct Eight {
  Doubles pose[12];
  Doubles size[3];
  Floats rgba[3];
  Floats emission;
};

// What becomes of them.
struct Seen {
  // 0: nothing of it is seen; 1: it is seen; 2: the near plane is in the way, or a number is not
  // finite: it must be taken by itself.
  static constexpr std::int32_t kNothing = 0;
  static constexpr std::int32_t kWhole = 1;
  static constexpr std::int32_t kByItself = 2;
  Ints state;
  Ints x0, x1, y0, y1;
  Floats center_z;
};

struct Sides {
  Floats a, b, c;  // of an Affine
};

struct SeenBoxes {
  Seen seen;
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

struct SeenCapsules {
  Seen seen;
  Conics conic[3];
  Sides axis;
  Floats along;  // of the camera
  RoundLight lit;
  Forms toward[3][kMaxLights];  // side, ends
};

struct SeenCylinders {
  Seen seen;
  Conics side;
  Sides plane[2];  // of its caps
  Ints front_count;
  Ints within;  // the camera is inside the infinite cylinder
  RoundLight lit;
  Forms toward[kMaxLights];
  Ints code;  // of the cap in front
};

// The set-up's inner loops.
struct EightsKernel {
  // 1 for each of the eight balls of which something may be in sight.
  void (*cull)(const Lens& lens, const Doubles (&position)[3], const Doubles& radius, Ints& sight);
  void (*boxes)(const Lens& lens, const Eight& eight, SeenBoxes& seen);
  void (*capsules)(const Lens& lens, const Eight& eight, SeenCapsules& seen);
  void (*cylinders)(const Lens& lens, const Eight& eight, SeenCylinders& seen);
  // How many come before each: by depth, or by number where depths are equal. All arrays have room
  // for whole blocks.
  void (*count_nearer)(const float* depth, const float* number, int count, std::int32_t* nearer);
};

}  // namespace engram::cpu
