#include "tasks/common/family_base.h"

#include <algorithm>
#include <utility>

#include "mjcf/object_descriptor.h"
#include "tasks/common/task_info.h"

namespace engram::tasks {

FamilyBase::FamilyBase(const RegistryEntry& entry) : info_(describe(entry)) {}

void FamilyBase::set_changeable(std::vector<TaskConstant> changeable,
                                const ConstantTable& changed) {
  if (!info_.answer.empty()) {
    info_.options.push_back(
        {kStrictOption, 0, true, 0, 1, "", "1: a wrong first answer fails the episode"});
  }
  info_.changeable = std::move(changeable);
  info_.canonical = info_.canonical && changed.empty();
  for (const TaskConstant& constant : info_.changeable) {
    const auto same = [&constant](const auto& one) { return one.first == constant.name; };
    if (std::ranges::none_of(changed, same)) continue;
    info_.changed.emplace_back(constant.name, constant.value);
    if (constant.name == kNoiseConstant) {
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
