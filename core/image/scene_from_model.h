// Render scene of a compiled MuJoCo model, and the poses of its geoms and cameras.
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <vector>

#include "core/image/renderer.h"
#include "core/math/frame.h"

namespace engram {

// The scene of a model, with the bodies and local poses of its geoms and cameras.
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

// Fill (geoms, 12) and (cameras, 12) for RenderInstances from the frames of the model's bodies. Do
// not allocate. With `visible`, the rows of geoms where it is 0 are left alone.
void pose_geoms(const ModelScene& scene, const Frame* bodies, float* geom_pose,
                const std::uint8_t* visible = nullptr);
void pose_cameras(const ModelScene& scene, const Frame* bodies, float* camera_pose);

}  // namespace engram
