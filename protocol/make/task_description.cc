#include "protocol/make/task_description.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/batch/queries.h"
#include "core/observe/proprio.h"
#include "core/sim/action_dim.h"
#include "protocol/io/json_values.h"
#include "protocol/make/accepted_bounds.h"
#include "protocol/make/baseline_scores.h"
#include "protocol/make/constant_warnings.h"

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

// A float as its shortest decimal: 0.1, not 0.10000000149011612.
double shortest_real(float value) {
  if (!std::isfinite(value)) return value;
  char text[32];
  const char* end = std::to_chars(text, text + sizeof text, value).ptr;
  double decimal = 0;
  std::from_chars(text, end, decimal);
  return decimal;
}

ConstantList names_of(const std::vector<Field>& fields) {
  ConstantList names;
  names.reserve(fields.size());
  for (const Field& field : fields) names.emplace_back(field.name);
  return names;
}

ConstantList bounds(const std::vector<float>& values) {
  ConstantList list;
  for (const float value : values) list.emplace_back(shortest_real(value));
  return list;
}

// Action spaces by control mode; a bound of null is none.
ConstantTable describe_actions(const Batch& batch) {
  const PhysicsModel& model = batch.physics_model();
  ConstantTable modes;
  for (int i = 0; i < kControlModes; ++i) {
    const auto mode = static_cast<ControlMode>(i);
    const Controller controller(mode, model.arm(), model.joint_ranges(),
                                batch.options().rotation_sign);
    const ActionSpace& space = controller.action_space();
    modes.emplace_back(name_of(mode), ConstantTable{{"dim", space.dim()},
                                                    {"low", bounds(space.low)},
                                                    {"high", bounds(space.high)},
                                                    {"normalized", space.normalized}});
  }
  return modes;
}

Constant number(bool integer, double value) {
  return integer ? Constant(static_cast<int>(value)) : Constant(value);
}

// A random variable or a TaskOptionSpec; `property` is the one that the other of them has not.
template <class Quantity>
ConstantTable describe_quantity(const Quantity& about, const char* property,
                                const Constant& value) {
  return {{"name", about.name},
          {property, value},
          {"integer", about.integer},
          {"low", number(about.integer, about.low)},
          {"high", number(about.integer, about.high)},
          {"unit", about.unit},
          {"description", about.description}};
}

ConstantList describe_random_variables(const std::vector<RandomVariable>& draws) {
  ConstantList list;
  for (const RandomVariable& draw : draws) {
    list.emplace_back(describe_quantity(draw, "width", draw.width));
  }
  return list;
}

// Values of the random variables; whole numbers are int64 in Python.
ConstantList describe_sampled_values(const TaskInfo& info) {
  ConstantList list;
  for (const Field& field : info.sampled_values) {
    list.emplace_back(ConstantTable{{"name", field.name},
                                    {"width", field.width},
                                    {"integer", field.dtype == DType::kInt32},
                                    {"unit", field.unit},
                                    {"description", field.description}});
  }
  return list;
}

// Options, with the value of this batch and that of the original's code.
ConstantList describe_options(const Batch& batch) {
  ConstantList list;
  const std::span<const double> values = Queries(batch).option_values();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const TaskOptionSpec& option = batch.info().options[i];
    const auto as_number = [&](double value) { return number(option.integer, value); };
    ConstantTable about = describe_quantity(option, "default", as_number(option.value));
    about.emplace_back("original", as_number(option.value_under(Rules::kOriginal)));
    about.emplace_back("value", as_number(values[i]));
    list.emplace_back(std::move(about));
  }
  return list;
}

const char* kind_name(TaskConstant::Kind kind) {
  using enum TaskConstant::Kind;
  switch (kind) {
    case kFixed:
      return "fixed";
    case kInteger:
      return "integer";
    case kReal:
      return "real";
    case kIntegerRange:
      return "integer range";
    case kRealRange:
      return "real range";
    case kReals:
      return "reals";
    case kName:
      return "name";
    case kNames:
      return "names";
    case kColors:
      return "colors";
  }
  return "";
}

// Constants that users may change, as they are in this batch.
ConstantList describe_changeable(const Batch& batch) {
  ConstantList list;
  for (const TaskConstant& declared : batch.info().constants) {
    if (!declared.changeable()) continue;
    const TaskConstant constant = accepted_bounds(batch, declared);
    ConstantTable about = {
        {"name", constant.name}, {"value", constant.value}, {"kind", kind_name(constant.kind)}};
    const bool counted = constant.kind != TaskConstant::Kind::kName;
    about.emplace_back("low", counted ? Constant(constant.low) : Constant());
    about.emplace_back("high", counted ? Constant(constant.high) : Constant());
    if (!constant.names.empty()) {
      about.emplace_back("names", ConstantList(constant.names.begin(), constant.names.end()));
    }
    about.emplace_back("unit", constant.unit);
    about.emplace_back("description", constant.description);
    list.emplace_back(std::move(about));
  }
  return list;
}

ConstantList describe_observation(const Batch& batch) {
  const std::span<const RangedField> ranged = Queries(batch).ranged_fields();
  return ranged.empty() ? describe_layout(Queries(batch).state_fields()) : describe_layout(ranged);
}

ConstantList describe_outputs(const Batch& batch) {
  ConstantList list;
  const ColumnStore& columns = BatchAccess::data(batch).outputs;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    list.emplace_back(describe_output(*batch.output(columns[i].field->name).field));
  }
  return list;
}

ConstantList describe_phases(const TaskInfo& info) {
  ConstantList list;
  for (const auto& [name, condition] : info.phases) {
    list.emplace_back(ConstantTable{{"name", name}, {"when", condition}});
  }
  return list;
}

ConstantList describe_props(const PhysicsModel& model) {
  ConstantList list;
  for (const PropModel& prop : model.props()) {
    list.emplace_back(ConstantTable{{"name", prop.name},
                                    {"motion", prop.free ? "free" : "kinematic"},
                                    {"mass", prop.mass},
                                    {"bounding_radius", prop.bounding_radius}});
  }
  return list;
}

// Observation of a batch of the default options: qpos, qvel, tcp_pose, then the task's fields.
int canonical_state_dim(const TaskInfo& info) {
  constexpr int kTcpPoseDim = 7;
  int dim = 2 * kRobotJoints + kTcpPoseDim;
  for (const Field& field : info.state_fields) dim += field.width;
  return dim;
}

// Measured scores of policies; nothing for tasks that differ from the benchmark's.
Constant describe_baseline_scores(const TaskInfo& info) {
  const RegistryEntry* entry = find_entry(info.id);
  const bool as_measured = std::ranges::none_of(info.constants, &TaskConstant::changed) &&
                           entry != nullptr && entry->horizon == info.horizon;
  const BaselineScores* baseline = as_measured ? find_baseline_scores(info.id) : nullptr;
  if (baseline == nullptr) return {};
  const auto share = [](double value) { return value < 0 ? Constant() : Constant(value); };
  const auto rates = [&share](double success, double answer) {
    return ConstantTable{{"success_once", success}, {"first_answer_correct", share(answer)}};
  };
  return ConstantTable{{"blind", rates(baseline->blind, baseline->blind_answer)},
                       {"sweep", rates(baseline->sweep, baseline->sweep_answer)},
                       {"oracle", rates(baseline->oracle, baseline->oracle_answer)}};
}

// The beginning of a description, which holds of the task in every batch.
ConstantTable describe_rules(const TaskInfo& info) {
  return {{"id", info.id},
          {"family", info.family},
          {"split", info.split},
          {"memory_type", info.memory_type},
          {"horizon", info.horizon},
          {"canonical", info.canonical},
          {"instruction", info.instruction},
          {"candidates", info.candidates},
          {"chance", info.chance()},
          {"answer", info.answer.empty() ? Constant() : Constant(info.answer)},
          {"answer_chance", info.answer.empty() ? Constant() : Constant(info.answer_chance())},
          {"ceilings", describe_baseline_scores(info)},
          {"termination", termination_name(info.termination)},
          {"frozen_cue", info.frozen_cue}};
}

// The answers that a policy may choose from (docs/choices.md); null if there is no list.
Constant describe_choices(const TaskInfo& info, const AnswerController* choices) {
  if (choices == nullptr) return {};
  const double chance = choices->choice_chance();
  const ChoiceForm form = choices->choice_form();
  return ConstantTable{{"question", form.question},
                       {"choices", form.items.empty() ? Constant()
                                                      : Constant(ConstantList(form.items.begin(),
                                                                              form.items.end()))},
                       {"least", form.least},
                       {"most", form.most},
                       {"repeats", form.repeats},
                       {"questions", form.questions},
                       {"chance", chance > 0 ? chance : info.chance()}};
}

// Keys of a description that lists show.
constexpr const char* kListed[] = {"id",        "family",    "split",       "memory_type",
                                   "horizon",   "canonical", "instruction", "action_dim",
                                   "state_dim", "candidates"};

}  // namespace

ConstantList describe_layout(const std::vector<Field>& fields) {
  ConstantList list;
  int offset = 0;
  for (const Field& field : fields) {
    list.emplace_back(ConstantTable{{"name", field.name},
                                    {"offset", offset},
                                    {"width", field.width},
                                    {"unit", field.unit},
                                    {"description", field.description}});
    offset += field.width;
  }
  return list;
}

ConstantList describe_layout(std::span<const RangedField> parts) {
  std::vector<Field> fields;
  for (const RangedField& part : parts) fields.push_back(part.field);
  ConstantList list = describe_layout(fields);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    ConstantTable& about = std::get<ConstantTable>(list[i].value);
    about.emplace_back("low", parts[i].low);
    about.emplace_back("high", parts[i].high);
    const std::vector<std::string>& names = parts[i].names;
    if (!names.empty()) about.emplace_back("names", ConstantList(names.begin(), names.end()));
  }
  return list;
}

ConstantTable describe_output(const Field& field) {
  return {
      {"name", field.name}, {"dtype", dtype_name(field.dtype)}, {"width", field.width},
      {"unit", field.unit}, {"description", field.description}, {"privileged", field.privileged}};
}

ConstantTable describe_entry(const RegistryEntry& entry) {
  const std::unique_ptr<Task> task = make_task(entry.id);
  ConstantTable known = describe_rules(task->info());
  known.emplace_back("action_dim", action_dim(entry.control_mode));
  known.emplace_back("state_dim", canonical_state_dim(task->info()));
  const Json description = std::move(known);
  ConstantTable listed;
  for (const char* key : kListed) listed.emplace_back(key, part(description, key));
  return listed;
}

ConstantTable describe_task(const Batch& batch) {
  const TaskInfo& info = batch.info();
  ConstantTable description = describe_rules(info);
  const ConstantTable rest = {
      {"action_dim", batch.action_dim()},
      {"control_mode", name_of(*batch.options().control_mode)},
      {"action_spaces", describe_actions(batch)},
      {"draws", describe_random_variables(Queries(batch).random_variables())},
      {"drawn", describe_sampled_values(info)},
      {"hidden", info.hidden_variable},
      {"rules", name_of(batch.options().rules)},
      {"options", describe_options(batch)},
      {"changeable", describe_changeable(batch)},
      {"changed", changed_constants(info.constants)},
      {"paraphrases", to_list(Queries(batch).paraphrases())},
      {"warnings", to_list(constant_warnings(info, batch.options()))},
      {"choices", describe_choices(info, Queries(batch).choices())},
      {"phases", describe_phases(info)},
      {"state_dim", batch.state_dim()},
      {"state_fields", describe_observation(batch)},
      {"proprio", describe_layout(proprio_fields(batch.options().joint_proprio))},
      {"segmentation_names", to_list(batch.images().segmentation_names)},
      {"task_cue_dim", info.task_cue_dim},
      {"oracle_dim", info.oracle_dim},
      {"outputs", describe_outputs(batch)},
      {"success_reward", info.success_reward},
      {"reward_terms", names_of(info.reward_terms)},
      {"props", describe_props(batch.physics_model())},
      {"constants", published_constants(info.constants)}};
  description.insert(description.end(), rest.begin(), rest.end());
  return description;
}

}  // namespace engram
