#include "tasks/custom/custom_family.h"

#include <array>
#include <deque>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "tasks/common/constant_binder.h"
#include "tasks/common/variant.h"
#include "tasks/custom/custom_task.h"
#include "tasks/family_content.h"
#include "tasks/registry.h"

namespace engram::tasks {
namespace {

// A family of one task, for the life of the process.
struct CustomFamily {
  Family family;
  std::array<TaskSpec, 1> rows;
  CustomDefinition definition;
  std::shared_ptr<const CustomFactory> factory;
};

// The values of constants, which a binder sets where a user has chosen others.
class ConstantValues {
 public:
  explicit ConstantValues(const std::vector<CustomConstant>& constants) : constants_(constants) {}

  void declare(ConstantBinder& binder) {
    for (const CustomConstant& constant : constants_) declare(binder, constant);
  }

  // After declare, and after the binder has taken over what users chose.
  static ConstantTable table(const std::vector<TaskConstant>& declared) {
    ConstantTable table;
    for (const TaskConstant& constant : declared) table.emplace_back(constant.name, constant.value);
    return table;
  }

 private:
  void declare(ConstantBinder& binder, const CustomConstant& about) {
    const char* name = about.name.c_str();
    const char* unit = about.unit.c_str();
    const char* text = about.text.c_str();
    const Bounds bounds{about.low, about.high};
    using Kind = TaskConstant::Kind;
    switch (about.kind) {
      case Kind::kInteger: {
        int& value = integers_.emplace_back(static_cast<int>(number(about.value, about)));
        binder.integer(name, value, bounds, unit, text);
        return;
      }
      case Kind::kReal: {
        double& value = reals_.emplace_back(number(about.value, about));
        binder.real(name, value, bounds, unit, text);
        return;
      }
      case Kind::kIntegerRange: {
        SampledRange<int>& value = integer_ranges_.emplace_back();
        value.low = static_cast<int>(end_of(about, 0));
        value.high = static_cast<int>(end_of(about, 1));
        binder.range(name, value, bounds, unit, text, {});
        return;
      }
      case Kind::kRealRange: {
        SampledRange<double>& value = real_ranges_.emplace_back();
        value.low = end_of(about, 0);
        value.high = end_of(about, 1);
        binder.range(name, value, bounds, unit, text, {});
        return;
      }
      case Kind::kName: {
        std::vector<const char*>& names = names_.emplace_back();
        for (const std::string& one : about.names) names.push_back(one.c_str());
        int& value = integers_.emplace_back(index_of(about));
        binder.name(name, value, names, text);
        return;
      }
      default:
        binder.fixed({{about.name, about.value}});
    }
  }

  [[noreturn]] static void refuse(const CustomConstant& about, const std::string& needed) {
    throw Error(Error::kInvalidArgument, "constant '" + about.name + "': " + in_words(about.value) +
                                             " given, " + needed + " needed");
  }
  static double number(const Constant& value, const CustomConstant& about) {
    const std::optional<double> found = as_number(value);
    if (!found) refuse(about, "a number");
    return *found;
  }
  static double end_of(const CustomConstant& about, std::size_t end) {
    const auto* list = std::get_if<ConstantList>(&about.value.value);
    if (list == nullptr || list->size() != 2) refuse(about, "[least, greatest]");
    return number((*list)[end], about);
  }
  static int index_of(const CustomConstant& about) {
    const auto* name = std::get_if<std::string>(&about.value.value);
    for (std::size_t i = 0; name != nullptr && i < about.names.size(); ++i) {
      if (about.names[i] == *name) return static_cast<int>(i);
    }
    refuse(about, "one of its names");
  }

  const std::vector<CustomConstant>& constants_;
  // They do not move: the binder writes to them.
  std::deque<int> integers_;
  std::deque<double> reals_;
  std::deque<SampledRange<int>> integer_ranges_;
  std::deque<SampledRange<double>> real_ranges_;
  std::deque<std::vector<const char*>> names_;
};

const CustomFamily& family_of(const RegistryEntry& entry) {
  // The family is its first member.
  return *reinterpret_cast<const CustomFamily*>(entry.definition);
}

std::unique_ptr<Task> make_custom(const RegistryEntry& entry, const ConstantTable& chosen) {
  const CustomFamily& own = family_of(entry);
  ConstantBinder binder(chosen);
  ConstantValues values(own.definition.constants);
  values.declare(binder);
  RegistryEntry task_entry = entry;
  task_entry.horizon = own.definition.horizon;
  declare_common(binder, task_entry);
  std::vector<TaskConstant> declared = binder.take();
  if (entry.max_episode_steps > 0) task_entry.horizon = entry.max_episode_steps;
  auto instance = own.factory->make(std::string(entry.base), ConstantValues::table(declared));
  auto task = std::make_unique<CustomTask>(task_entry, std::move(instance));
  task->set_constants(std::move(declared));
  return task;
}

std::unique_ptr<CustomFamily> new_family(CustomDefinition definition,
                                         std::shared_ptr<const CustomFactory> factory) {
  auto own = std::make_unique<CustomFamily>();
  own->definition = std::move(definition);
  own->factory = std::move(factory);
  const CustomDefinition& about = own->definition;
  own->rows[0] = {.id = about.id,
                  .horizon = about.horizon,
                  .split = Split::kExtended,
                  .oracle_floor = about.oracle_floor,
                  .instruction = about.instruction};
  own->family = {.name = about.family,
                 .memory_type = about.memory_type,
                 .tasks = own->rows,
                 .make = &make_custom};
  return own;
}

}  // namespace

void register_custom(CustomDefinition definition, std::shared_ptr<const CustomFactory> factory) {
  if (definition.horizon < 1) {
    throw Error(Error::kInvalidArgument, "task '" + definition.id + "': horizon " +
                                             std::to_string(definition.horizon) +
                                             " given, at least 1 control step needed");
  }
  const IeeeScope scope;
  std::unique_ptr<CustomFamily> own = new_family(std::move(definition), std::move(factory));
  const TaskSpec& row = own->rows[0];
  const RegistryEntry trial = {.id = row.id,
                               .family = own->family.name,
                               .horizon = row.horizon,
                               .split = row.split,
                               .memory_type = own->family.memory_type,
                               .instruction = row.instruction,
                               .oracle_floor = row.oracle_floor,
                               .definition = &own->family,
                               .base = row.id};
  (void)own->family.make(trial, {});
  if (!own->definition.content.empty()) set_content(own->family, own->definition.content);
  register_family(own->family);
  (void)own.release();  // the registry points to it for the life of the process
}

}  // namespace engram::tasks
