// A lamp that a task switches. Every environment has its own light.
#pragma once

#include <string>

#include "core/sim/state.h"
#include "mjcf/scene.h"
#include "tasks/common/constant_binder.h"

namespace engram::tasks {

// Light of the bulb. It is rgba x (light of the scene + emission): 1 or more makes a pure colour
// flat and saturated, 0 is an unlit bulb.
struct LampLight {
  mjcf::Rgba rgba{1, 1, 1, 1};
  double emission = 0;
};

// Declares the lamp's measures.
void declare_lamp(ConstantBinder& constants);

class Lamp {
 public:
  Lamp() = default;
  // Appends the lamp's props, "<name>_body" and "<name>_bulb", to a scene.
  Lamp(mjcf::Scene& scene, const std::string& name);

  // Stands the lamp somewhere; pos is the middle of its underside.
  void place(const State& state, int env, const double* pos) const;
  void place(const State& state, int env, const double* pos, const double* quat) const;
  void shine(const State& state, int env, const LampLight& light) const;

  int body() const { return body_; }  // index of the prop
  int bulb() const { return bulb_; }

 private:
  int body_ = -1;
  int bulb_ = -1;
};

}  // namespace engram::tasks
