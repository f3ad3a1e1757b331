// A scene of which some never moves, seen by two cameras.
#pragma once

#include <vector>

#include "tests/render/render_fixture.h"

namespace engram::test {

inline std::vector<InstructionSet> sets() {
  std::vector<InstructionSet> all;
  for (const InstructionSet set :
       {InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (is_supported(set)) all.push_back(set);
  }
  return all;
}

// Of renderers that draw all sizes of these tests.
inline CpuRendererOptions with(InstructionSet set, bool antialias = false) {
  CpuRendererOptions options;
  options.instruction_set = set;
  options.antialias = antialias;
  options.max_width = 1300;
  options.max_height = 300;
  return options;
}

// Two cameras, the first of which never moves, nor do floor, table and every fifth geom.
inline RenderRig still_life(unsigned seed) {
  RenderRig rig = crowd(seed);
  for (std::size_t i = 0; i < rig.scene.geoms.size(); ++i) {
    rig.scene.geoms[i].still = i < 2 || i % 5 == 0;
  }
  rig.scene.cameras[0].still = true;
  rig.scene.cameras.push_back(rig.scene.cameras[0]);
  rig.scene.cameras[1].still = false;
  return rig;
}

inline RenderInstances two_cameras(const RenderRig& rig, std::vector<float>& poses) {
  poses.assign(rig.camera_pose.begin(), rig.camera_pose.end());
  poses.insert(poses.end(), rig.camera_pose.begin(), rig.camera_pose.end());
  poses[12 + 9] += 0.1F;
  poses[12 + 11] -= 0.15F;
  RenderInstances instances = rig.instances();
  instances.camera_pose = poses.data();
  return instances;
}

}  // namespace engram::test
