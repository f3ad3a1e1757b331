#include "tasks/common/lamp.h"

#include <algorithm>

#include "mjcf/lamp.h"
#include "tasks/common/poses.h"

namespace engram::tasks {

void declare_lamp(ConstantBinder& constants) {
  constants.fixed({{"LAMP_BASE_RADIUS", 0.018},
                   {"LAMP_BASE_HALF_HEIGHT", 0.008},
                   {"LAMP_STEM_RADIUS", 0.004},
                   {"LAMP_STEM_HALF_HEIGHT", 0.020},
                   {"LAMP_BULB_RADIUS", 0.012}});
}

Lamp::Lamp(mjcf::Scene& scene, const std::string& name)
    : body_(static_cast<int>(scene.props.size())), bulb_(body_ + 1) {
  scene.props.push_back(mjcf::lamp_body(name + "_body"));
  scene.props.push_back(mjcf::lamp_bulb(name + "_bulb"));
}

void Lamp::place(const State& state, int env, const double* pos) const {
  place(state, env, pos, kUprightQuat);
}

void Lamp::place(const State& state, int env, const double* pos, const double* quat) const {
  state.place_prop(env, body_, pos, quat);
  state.place_prop(env, bulb_, pos, quat);
}

void Lamp::shine(const State& state, int env, const LampLight& light) const {
  std::transform(light.rgba.begin(), light.rgba.end(), state.prop_rgba.row(env) + 4 * bulb_,
                 [](double value) { return static_cast<float>(value); });
  state.prop_emission.row(env)[bulb_] = static_cast<float>(light.emission);
}

}  // namespace engram::tasks
