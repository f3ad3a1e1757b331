#include "apps/task_description.h"

#include <fmt/format.h>

#include "apps/output.h"

namespace engram::apps {
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

// --- in words ---

std::string plain(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  return value.is_null() ? "-" : value.dump();
}

// A table of objects: one column per key, under a heading.
std::string section(const std::string& title, const Json& rows,
                    const std::vector<Table::Column>& columns) {
  if (rows.empty()) return "";
  Table table(columns);
  for (const Json& row : rows) {
    std::vector<std::string> cells;
    cells.reserve(columns.size());
    for (const Table::Column& column : columns) cells.push_back(plain(row[column.name]));
    table.add(std::move(cells));
  }
  return fmt::format("\n{}\n{}", title, table.text("  "));
}

std::string head(const Json& task) {
  return fmt::format(
      "{}: \"{}\"\n"
      "  family {}, split {}, memory type {}, {}\n"
      "  horizon {} control steps; ends early: {}; actions frozen until the cue is over: {}\n"
      "  {} candidates; a guess succeeds with probability {:.3f}\n",
      plain(task["id"]), plain(task["instruction"]), plain(task["family"]), plain(task["split"]),
      plain(task["memory_type"]), task["canonical"] ? "canonical" : "not canonical",
      plain(task["horizon"]), plain(task["termination"]), task["frozen_cue"] ? "yes" : "no",
      plain(task["candidates"]), task["chance"].get<double>());
}

std::string action_section(const Json& modes) {
  Table table({{"mode"}, {"dim", true}, {"low"}, {"high"}});
  const auto shortened = [](const Json& values) {
    bool same = true;
    for (const Json& value : values) same = same && value == values[0];
    return same ? fmt::format("{} each", plain(values[0])) : values.dump();
  };
  for (const auto& [mode, space] : modes.items()) {
    table.add({mode, space["dim"].dump(), shortened(space["low"]), shortened(space["high"])});
  }
  return "\nActions by control mode\n" + table.text("  ");
}

std::string constant_section(const Json& constants) {
  std::string text = "\nConstants\n";
  for (const auto& [name, value] : constants.items()) {
    text += fmt::format("  {} = {}\n", name, plain(value));
  }
  return constants.empty() ? "" : text;
}

std::string reward_section(const Json& task) {
  std::string text = fmt::format("\nReward\n  dense reward of a success step: {}\n",
                                 plain(task["success_reward"]));
  if (!task["reward_terms"].empty()) {
    text += "  terms (info reward_dict):";
    for (const Json& term : task["reward_terms"]) text += fmt::format(" {}", plain(term));
    text += "\n";
  }
  return text;
}

}  // namespace

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

std::string describe_in_words(const Json& task) {
  const Table::Column name{"name"};
  const Table::Column width{"width", true};
  const Table::Column unit{"unit"};
  const Table::Column description{"description"};
  const Table::Column offset{"offset", true};
  return head(task) + section("Phases", task["phases"], {name, {"when"}}) +
         section("Drawn per episode, can be pinned", task["draws"],
                 {name, width, {"integer"}, {"low", true}, {"high", true}, unit, description}) +
         section("Options of the task", task["options"],
                 {name,
                  {"default", true},
                  {"integer"},
                  {"low", true},
                  {"high", true},
                  unit,
                  description}) +
         section("Props", task["props"],
                 {name, {"motion"}, {"mass", true}, {"bounding_radius", true}}) +
         action_section(task["action_spaces"]) +
         section(fmt::format("State observation, {} values", plain(task["state_dim"])),
                 task["state_fields"], {name, offset, width, unit, description}) +
         section("Proprio", task["proprio"], {name, offset, width, unit, description}) +
         section("Outputs", task["outputs"], {name, {"dtype"}, width, unit, description}) +
         reward_section(task) + constant_section(task["constants"]);
}

}  // namespace engram::apps
