#include "tasks/parts/family_base.h"

#include "tasks/parts/task_info.h"

namespace engram::tasks {

FamilyBase::FamilyBase(const RegistryEntry& entry) : info_(describe(entry)) {}

SceneSource FamilyBase::scene() const { return scene_source(scene_); }

}  // namespace engram::tasks
