// Compiled scenes and small measurements for the tests of mjcf.
#pragma once

#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/scene/mujoco_handle.h"
#include "mjcf/scene.h"

namespace engram::mjcf::test {

using Arm = std::array<double, 9>;  // seven arm joints, two fingers

inline constexpr double kPi = 3.14159265358979323846;

// Poses of the robot at which the TCP is known.
inline constexpr Arm kRest = {0, kPi / 8, 0, -5 * kPi / 8, 0, 3 * kPi / 4, kPi / 4, 0.04, 0.04};
inline constexpr Arm kBuilder = {0, kPi / 8, 0, -5 * kPi / 8, 0, 3 * kPi / 4, -kPi / 4, 0.04, 0.04};
inline constexpr Arm kMikasa = {0, 0, 0, -2 * kPi / 3, 0, 2 * kPi / 3, kPi / 4, 0.04, 0.04};
inline constexpr Arm kMenagerie = {0, 0, 0, -1.57079, 0, 1.57079, -0.7853, 0.04, 0.04};

using Model = ModelPtr;
using Data = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

inline Model compile(const Scene& scene, Detail detail) {
  return compile_model(compose(scene, detail));
}

// A scene that MuJoCo itself moves, without gravity in the model.
inline Model compile_driven(const Scene& scene, Detail detail) {
  Model model = compile(scene, detail);
  model->opt.gravity[2] = 0;
  return model;
}

inline int id(const Model& model, mjtObj type, const std::string& name) {
  const int result = mj_name2id(model.get(), type, name.c_str());
  if (result < 0) throw std::runtime_error("no " + name);
  return result;
}

// Data with the robot at a pose and its drives holding it; everything up to date.
inline Data make_data(const Model& model, const Arm& pose) {
  Data data(mj_makeData(model.get()), mj_deleteData);
  std::copy(pose.begin(), pose.end(), data->qpos);
  std::copy(pose.begin(), pose.end(), data->ctrl);
  mj_forward(model.get(), data.get());
  return data;
}

// Steps in MuJoCo; the weight of free props comes from outside.
inline void step(const Model& model, const Data& data) {
  for (int joint = 0; joint < model->njnt; ++joint) {
    if (model->jnt_type[joint] != mjJNT_FREE) continue;
    const int body = model->jnt_bodyid[joint];
    data->xfrc_applied[6 * body + 2] = -9.81 * model->body_mass[body];
  }
  mj_step(model.get(), data.get());
}

inline constexpr int kVisual = 2;  // group of geoms that are drawn

struct RayHit {
  double distance = -1;  // in lengths of the ray
  int geom = -1;
};

// The first geom of a group that a ray meets.
inline RayHit cast_ray(const Model& model, const Data& data, const mjtNum* from,
                       const mjtNum* along, int group) {
  mjtByte groups[mjNGROUP] = {};
  groups[group] = 1;
  RayHit hit;
#if mjVERSION_HEADER >= 300
  hit.distance = mj_ray(model.get(), data.get(), from, along, groups, 1, -1, &hit.geom, nullptr);
#else
  hit.distance = mj_ray(model.get(), data.get(), from, along, groups, 1, -1, &hit.geom);
#endif
  return hit;
}

// A row of cubes of 4 cm on the table, out of the arm's way.
inline Scene cubes(int count) {
  Scene scene;
  const int middle = count / 2;
  for (int i = 0; i < count; ++i) {
    Prop prop = cube("cube" + std::to_string(i), 0.02, {1, 0, 0, 1});
    prop.pos = {0.15, 0.1 * (i - middle), 0.02};
    scene.props.push_back(prop);
  }
  return scene;
}

}  // namespace engram::mjcf::test
