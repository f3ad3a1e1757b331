// Small helpers with which tasks describe themselves.
#pragma once

#include "core/task/task.h"
#include "mjcf/scene.h"
#include "tasks/registry.h"

namespace engram::tasks {

// A TaskInfo with what the registry knows. RL tasks end at success.
TaskInfo describe(const RegistryEntry& entry);

// Addition to TaskInfo::answer of tasks that end at success, before the robot rests.
inline constexpr const char* kSuccessAnswers = "; or success";

// The scene as the engine takes it.
SceneSpec scene_source(const mjcf::Scene& scene);

// TaskInfo::phases of the families with cue, empty and manipulation phase.
std::vector<std::pair<std::string, std::string>> cue_empty_manipulation_phases();

}  // namespace engram::tasks
