#include "tasks/common/task_info.h"

#include "core/base/index.h"

namespace engram::tasks {

TaskInfo describe(const RegistryEntry& entry) {
  TaskInfo info;
  info.id = entry.id;
  info.family = entry.family;
  info.split = split_name(entry.split);
  info.memory_type = entry.memory_type;
  info.instruction = entry.instruction;
  info.canonical = entry.canonical;
  info.horizon = entry.horizon;
  info.control_mode = entry.control_mode;
  if (entry.is_rl()) info.termination = Termination::kSuccess;
  return info;
}

SceneSpec scene_source(const mjcf::Scene& scene) {
  SceneSpec source;
  for (const mjcf::Prop& prop : scene.props) source.props.push_back(prop.name);
  source.compose = [scene](std::span<const int> props, RobotDetail detail) {
    mjcf::Scene part;
    part.render_view = scene.render_view;
    part.table_ends = scene.table_ends;
    part.wrist_camera = scene.wrist_camera;
    for (const int prop : props) part.props.push_back(scene.props[at(prop)]);
    return mjcf::compose(part, detail == RobotDetail::kDynamics ? mjcf::Detail::kRobotDynamics
                                                                : mjcf::Detail::kPhysics);
  };
  return source;
}

std::vector<std::pair<std::string, std::string>> cue_empty_manipulation_phases() {
  return {{"cue", "elapsed < cue_steps"},
          {"empty", "cue_steps <= elapsed < cue_steps + empty_steps"},
          {"manipulation", "elapsed >= cue_steps + empty_steps"}};
}

}  // namespace engram::tasks
