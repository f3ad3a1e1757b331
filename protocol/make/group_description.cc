#include "protocol/make/group_description.h"

#include "core/base/join.h"
#include "protocol/make/task_description.h"

namespace engram {
namespace {

// Rows of states have no ranges.
ConstantList describe_state_fields(const Batch& group) {
  const std::vector<RangedField>& row = group.output_arrays().row_fields();
  if (observes_objects(group.part(0).options().obs_mode)) {
    return describe_layout(std::span<const RangedField>(row));
  }
  std::vector<Field> fields;
  for (const RangedField& field : row) fields.push_back(field.field);
  return describe_layout(fields);
}

// Columns of the group; final_mask and images are arrays of every batch.
ConstantList describe_group_outputs(const Batch& group) {
  ConstantList list;
  for (const OutputArray& array : group.output_arrays().now()) {
    if (array.shape.size() > 2 || array.field.name == "final_mask") continue;
    list.emplace_back(describe_output(array.field));
  }
  return list;
}

}  // namespace

ConstantTable describe_group(const Batch& group) {
  if (!group.is_common()) return describe_task(group.part(0));
  ConstantList tasks;
  ConstantList warnings;
  std::vector<std::string> ids;
  Constant action_spaces;
  Constant proprio;
  int first_env = 0;
  for (int i = 0; i < group.num_parts(); ++i) {
    const int num_envs = group.part(i).num_envs();
    ConstantTable task = {{"first_env", first_env}, {"num_envs", num_envs}};
    first_env += num_envs;
    ConstantTable description = describe_task(group.part(i));
    task.insert(task.end(), description.begin(), description.end());
    ids.push_back(group.part(i).info().id);
    const Json known = std::move(description);
    for (const Json& warning : list(part(known, "warnings"))) warnings.push_back(warning);
    action_spaces = part(known, "action_spaces");
    proprio = part(known, "proprio");
    tasks.emplace_back(std::move(task));
  }
  const Batch& first = group.part(0);
  return {{"id", join(ids, {}, "+")},
          {"family", ""},
          {"horizon", group.horizon()},
          {"action_dim", group.action_dim()},
          {"control_mode", name_of(*first.options().control_mode)},
          {"action_spaces", action_spaces},
          {"rules", name_of(first.options().rules)},
          {"warnings", warnings},
          {"state_dim", group.state_dim()},
          {"state_fields", describe_state_fields(group)},
          {"proprio", proprio},
          {"segmentation_names", ConstantList{}},
          {"drawn", ConstantList{}},
          {"outputs", describe_group_outputs(group)},
          {"tasks", tasks}};
}

}  // namespace engram
