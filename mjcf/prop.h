// Props: objects on the table, described once for physics and for rendering.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/task/object_descriptor.h"

namespace engram::mjcf {

using Vec3 = std::array<double, 3>;
using Quat = std::array<double, 4>;  // (w, x, y, z)
using Rgba = std::array<double, 4>;  // 0..1

enum class GeomType { kBox, kSphere, kCapsule, kCylinder, kEllipsoid, kMesh };

// One geom of a prop, posed in the frame of the prop's body.
struct Geom {
  GeomType type = GeomType::kBox;
  Vec3 size{};  // MuJoCo's convention: half sizes; radius; radius and half length along z
  Vec3 pos{};
  Quat quat{1, 0, 0, 0};
  Rgba rgba{1, 1, 1, 1};  // linear
  bool collides = true;
  bool visible = true;
  double emission = 0;
  bool hidden_from_sensors = false;  // visible to people only
  std::vector<Vec3> corners = {};    // of a mesh: those of its convex hull, m
};

// Motion of a body.
enum class BodyType {
  kDynamic,    // six degrees of freedom, moved by physics
  kKinematic,  // moved by the task only (a mocap body); pushes, is never pushed
};

inline constexpr double kDensity = 1000;  // kg/m^3, where a prop's mass is not its own

struct Prop {
  std::string name;
  BodyType body_type = BodyType::kDynamic;
  bool pushes_props = false;  // kinematic, and moves against dynamic props
  std::vector<Geom> geoms;
  // Inertial properties of a dynamic prop; about the centre of mass, in body axes.
  double mass = 0;                      // kg
  Vec3 center_of_mass{};                // m
  std::array<double, 6> inertia{};      // kg m^2: xx, yy, zz, xy, xz, yz
  double friction = 0.3;                // the material's; a pair takes the average
  double damping = 0;                   // of all six velocities: N s/m, N m s/rad
  ObjectKind kind = ObjectKind::kPart;  // in the objects observation
  int object_shape = -1;                // ObjectShape, -1: none of those
  double travel = 0;                    // m: a button's cap sinks at most so far
  Vec3 pos{0, 0, 0.02};                 // pose in the document (qpos0); tasks place it at reset
  Quat quat{1, 0, 0, 0};
};

// A solid cube of density 1000 kg/m^3, resting on the table.
Prop cube(const std::string& name, double half_size, const Rgba& rgba);

// A sphere for rendering only, moved by the task; it does not collide.
Prop visual_sphere(const std::string& name, double radius, const Rgba& rgba);

}  // namespace engram::mjcf
