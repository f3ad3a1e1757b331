#include "tasks/common/family_base.h"

#include <utility>

#include "mjcf/object_descriptor.h"
#include "tasks/common/paraphrases.h"
#include "tasks/common/task_info.h"
#include "tasks/common/task_options.h"

namespace engram::tasks {

FamilyBase::FamilyBase(const RegistryEntry& entry) : info_(describe(entry)) {
  scene_.wrist_camera = entry.wrist_camera;
}

std::vector<std::string> FamilyBase::paraphrases(std::string_view instruction) const {
  return engram::paraphrases(instruction);
}

void FamilyBase::set_constants(std::vector<TaskConstant> constants) {
  if (!info_.answer.empty()) {
    TaskOptions(info_.options)
        .on_off(kStrictOption, "1: a wrong first answer fails the episode", /*original=*/false);
  }
  info_.constants = std::move(constants);
  for (const TaskConstant& constant : info_.constants) {
    if (constant.changed) info_.canonical = false;
    if (constant.chosen && constant.name == kNoiseConstant) {
      info_.robot_init_qpos_noise = std::get<double>(constant.value.value);
    }
  }
}

std::vector<ObjectDescriptor> FamilyBase::object_descriptors() const {
  std::vector<ObjectDescriptor> looks;
  for (const mjcf::Prop& prop : scene_.props) looks.push_back(mjcf::describe_object(prop));
  return looks;
}

SceneSpec FamilyBase::scene() const { return scene_source(scene_); }

}  // namespace engram::tasks
