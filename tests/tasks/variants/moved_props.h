// What tests of variants do with props: read them in a document, and put them somewhere in an
// environment without physics.
#pragma once

#include <cstdlib>
#include <memory>
#include <string>

#include "tests/env_helpers.h"

namespace engram::test {

// The first such number after that name in a scene's document, or -1.
inline double number_in(const std::string& document, const std::string& prop,
                        const std::string& attribute) {
  const std::size_t body = document.find("\"" + prop + "\"");
  const std::size_t found = document.find(" " + attribute + "=\"", body);
  if (body == std::string::npos || found == std::string::npos) return -1;
  return std::atof(document.c_str() + found + attribute.size() + 3);
}

inline double mass_in(const std::string& document, const std::string& prop) {
  return number_in(document, prop, "mass");
}

// A batch of one without physics, with dense rewards.
inline std::unique_ptr<Batch> make_still(const char* id, const ConstantTable& constants,
                                         std::vector<Pin> pins = {}) {
  auto batch = make_running(id, MakeOptions{{.reward_mode = RewardMode::kDense,
                                             .auto_reset = AutoReset::kOff,
                                             .substeps = 0,
                                             .pins = std::move(pins)},
                                            constants});
  return batch;
}

// One step with the origin of a prop there.
inline void step_with(Batch& batch, int prop, double x, double y, double z) {
  double* pos = batch.state().prop_pos_of(0, prop);
  pos[0] = x;
  pos[1] = y;
  pos[2] = z;
  step(batch, Policy::kZero);
}

inline bool succeeds_with(Batch& batch, int prop, double x, double y, double z) {
  step_with(batch, prop, x, y, z);
  return batch.outputs().success[0] != 0;
}

// The draw of that name.
inline RandomVariable draw_of(const TaskInfo& info, const std::string& name) {
  for (const RandomVariable& draw : info.random_variables) {
    if (draw.name == name) return draw;
  }
  return {};
}

// The changed penalty costs this much in a step in which everything else is equal.
inline float dense_reward_of(const char* id, const ConstantTable& constants) {
  const auto batch = make_still(id, constants);
  std::vector<float> action = zeros(*batch);
  action[0] = 1;
  batch->step(action);
  return batch->outputs().reward[0];
}

}  // namespace engram::test
