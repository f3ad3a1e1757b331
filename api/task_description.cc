#include "api/task_description.h"

namespace engram {
namespace {

const char* termination_name(Termination rule) {
  switch (rule) {
    case Termination::kNever:
      return "never";
    case Termination::kSuccess:
      return "success";
    case Termination::kSuccessOrFailed:
      return "success or failed";
  }
  return "";
}

Json bounds(const std::vector<float>& values) {
  Json array = Json::array();
  for (const float value : values) array.push_back(to_json(value));
  return array;
}

// Per control mode; a bound of null is none.
Json describe_actions(const VectorEnv& env) {
  const PhysicsModel& model = env.physics_model();
  Json modes = Json::object();
  for (int i = 0; i < kControlModes; ++i) {
    const auto mode = static_cast<ControlMode>(i);
    const Controller controller(mode, model.arm(), model.joint_ranges(),
                                env.options().rotation_sign);
    const ActionSpace& space = controller.action_space();
    modes[control_mode_name(mode)] = {{"dim", space.dim()},
                                      {"low", bounds(space.low)},
                                      {"high", bounds(space.high)},
                                      {"normalized", space.normalized}};
  }
  return modes;
}

Json bound(const Draw& draw, double value) {
  return draw.integer ? Json(static_cast<std::int64_t>(value)) : to_json(value);
}

Json describe_draws(const std::vector<Draw>& draws) {
  Json array = Json::array();
  for (const Draw& draw : draws) {
    array.push_back({{"name", draw.name},
                     {"width", draw.width},
                     {"integer", draw.integer},
                     {"low", bound(draw, draw.low)},
                     {"high", bound(draw, draw.high)},
                     {"unit", draw.unit},
                     {"description", draw.description}});
  }
  return array;
}

Json describe_options(const std::vector<TaskOption>& options) {
  Json array = Json::array();
  for (const TaskOption& option : options) {
    const auto number = [&option](double value) {
      return option.integer ? Json(static_cast<std::int64_t>(value)) : to_json(value);
    };
    array.push_back({{"name", option.name},
                     {"default", number(option.value)},
                     {"integer", option.integer},
                     {"low", number(option.low)},
                     {"high", number(option.high)},
                     {"unit", option.unit},
                     {"description", option.description}});
  }
  return array;
}

// Parts of a row, one after the other.
Json describe_layout(const std::vector<Field>& fields) {
  Json array = Json::array();
  int offset = 0;
  for (const Field& field : fields) {
    array.push_back({{"name", field.name},
                     {"offset", offset},
                     {"width", field.width},
                     {"unit", field.unit},
                     {"description", field.description}});
    offset += field.width;
  }
  return array;
}

// The seven values of common 6.3.
std::vector<Field> proprio_fields() {
  return {{"tcp_position", 3, DType::kFloat32, "m", "world frame"},
          {"roll", 1, DType::kFloat32, "rad", "about the fixed x axis, first"},
          {"pitch", 1, DType::kFloat32, "rad", "about the fixed y axis, second"},
          {"yaw", 1, DType::kFloat32, "rad", "about the fixed z axis, third"},
          {"gripper_opening", 1, DType::kFloat32, "m", "sum of both fingers, 0 to 0.08"}};
}

Json describe_outputs(const ColumnStore& outputs) {
  Json array = Json::array();
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const Field& field = *outputs[i].field;
    array.push_back({{"name", field.name},
                     {"dtype", dtype_name(field.dtype)},
                     {"width", field.width},
                     {"unit", field.unit},
                     {"description", field.description}});
  }
  return array;
}

Json describe_phases(const TaskInfo& info) {
  Json array = Json::array();
  for (const auto& [name, condition] : info.phases) {
    array.push_back({{"name", name}, {"when", condition}});
  }
  return array;
}

Json describe_props(const PhysicsModel& model) {
  Json array = Json::array();
  for (const PropModel& prop : model.props()) {
    array.push_back({{"name", prop.name},
                     {"motion", prop.free ? "free" : "kinematic"},
                     {"mass", to_json(prop.mass)},
                     {"bounding_radius", to_json(prop.bounding_radius)}});
  }
  return array;
}

constexpr int kCanonicalActionDim = 7;  // of pd_ee_delta_pose

// qpos, qvel, tcp_pose, then the task's fields: what a batch of the default options observes.
int canonical_state_dim(const TaskInfo& info) {
  constexpr int kTcpPoseDim = 7;
  int dim = 2 * kRobotJoints + kTcpPoseDim;
  for (const Field& field : info.state_fields) dim += field.width;
  return dim;
}

}  // namespace

Json describe_entry(const RegistryEntry& entry) {
  const std::unique_ptr<Task> task = make_task(entry.id);
  const TaskInfo& info = task->info();
  return {{"id", entry.id},
          {"family", entry.family},
          {"split", split_name(entry.split)},
          {"memory_type", entry.memory_type},
          {"horizon", entry.horizon},
          {"canonical", entry.canonical},
          {"instruction", entry.instruction},
          {"action_dim", kCanonicalActionDim},
          {"state_dim", canonical_state_dim(info)},
          {"candidates", info.candidates}};
}

Json describe_task(const VectorEnv& env) {
  const TaskInfo& info = env.info();
  return {{"id", info.id},
          {"family", info.family},
          {"split", info.split},
          {"memory_type", info.memory_type},
          {"horizon", info.horizon},
          {"canonical", info.canonical},
          {"instruction", info.instruction},
          {"candidates", info.candidates},
          {"chance", info.chance()},
          {"termination", termination_name(info.termination)},
          {"frozen_cue", info.frozen_cue},
          {"action_dim", env.action_dim()},
          {"control_mode", control_mode_name(env.options().control_mode)},
          {"action_spaces", describe_actions(env)},
          {"draws", describe_draws(env.draws())},
          {"options", describe_options(info.options)},
          {"phases", describe_phases(info)},
          {"state_dim", env.state_dim()},
          {"state_fields", describe_layout(env.state_fields())},
          {"proprio", describe_layout(proprio_fields())},
          {"task_cue_dim", info.task_cue_dim},
          {"oracle_dim", info.oracle_dim},
          {"outputs", describe_outputs(env.outputs())},
          {"success_reward", to_json(info.success_reward)},
          {"reward_terms", info.reward_terms},
          {"props", describe_props(env.physics_model())},
          {"constants", to_json(info.constants)}};
}

}  // namespace engram
