// What a compiled MuJoCo model looks like, and where its geoms and cameras are.
#pragma once

#include <mujoco/mujoco.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/image/renderer.h"

namespace engram {

// The scene of a model, and for its geoms and cameras what a renderer's caller needs.
struct ModelScene {
  RenderScene scene;
  std::vector<int> model_geom;    // per geom: its index in the model
  std::vector<int> geom_body;     // per geom: the body that it is fixed to
  std::vector<float> geom_local;  // (geoms, 12) pose in that body's frame
  std::vector<float> rgba;        // (geoms, 4) as the model has it
  std::vector<float> emission;    // (geoms)
  std::vector<int> camera_body;
  std::vector<float> camera_local;  // (cameras, 12)
};

// Takes geoms of groups 0 to 2 (without `for_people`, not of group 1) that are not transparent,
// fixed cameras by name, active directional lights, and as ambient light that of the headlight and
// of all lights together. Materials whose name contains "wood" become wood, "grid", "floor" or
// "tile" a grid; other textures their mean colour. Segments are indices of geoms in the model,
// plus 1. Specular light, the headlight's diffuse light and lights that are not directional are
// left out. No light casts shadows unless the model says so.
//
// Throws Error if a geom is of a type that renderers do not know.
ModelScene scene_from_model(const mjModel& model, bool for_people = true);

// Poses of bodies in the world: entry i of `position` starts at position + i * position_stride.
// mjData's are {xpos, 3, xquat, 4}; rows of (x, y, z, qw, qx, qy, qz) are {rows, 7, rows + 3, 7}.
template <typename Number>
struct BodyPoses {
  const Number* position = nullptr;
  std::ptrdiff_t position_stride = 3;
  const Number* quaternion = nullptr;  // (w, x, y, z), of length 1
  std::ptrdiff_t quaternion_stride = 4;
};

// Fill (geoms, 12) and (cameras, 12) for RenderInstances. Do not allocate. With `visible`, the rows
// of geoms where it is 0 are left alone.
void pose_geoms(const ModelScene& scene, const BodyPoses<double>& bodies, float* geom_pose,
                const std::uint8_t* visible = nullptr);
void pose_geoms(const ModelScene& scene, const BodyPoses<float>& bodies, float* geom_pose,
                const std::uint8_t* visible = nullptr);
void pose_cameras(const ModelScene& scene, const BodyPoses<double>& bodies, float* camera_pose);
void pose_cameras(const ModelScene& scene, const BodyPoses<float>& bodies, float* camera_pose);

}  // namespace engram
