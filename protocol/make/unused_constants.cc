#include "protocol/make/unused_constants.h"

#include <algorithm>
#include <memory>

#include "core/base/join.h"
#include "tasks/registry.h"

namespace engram {
namespace {

// The task without one of its constants; null if the others are refused without it.
std::unique_ptr<Task> without(std::string_view base, ConstantTable constants,
                              const std::string& name) {
  std::erase_if(constants, [&](const auto& one) { return one.first == name; });
  try {
    return make_task(base, constants);
  } catch (const Error&) {
    return nullptr;
  }
}

bool is_chosen(const TaskOptionSpec& option, const BatchOptions& options) {
  return std::ranges::any_of(options.task_options, [&](const TaskOptionValue& choice) {
    return choice.name == option.name;
  });
}

std::string warning(const std::string& constant, const Constant& value,
                    const TaskOptionSpec& option, Rules rules) {
  return constant + "=" + in_words(value) + " has no effect on " + option.name + ", which is " +
         shortest(option.value_under(rules)) + " with rules=" + name_of(rules) + "; the option " +
         option.name + " sets it";
}

}  // namespace

std::vector<std::string> unused_constants(const TaskInfo& info, const BatchOptions& options) {
  std::vector<std::string> warnings;
  if (options.rules == Rules::kReference) return warnings;  // defaults are in force
  const RegistryEntry* entry = find_entry(info.id);
  if (entry == nullptr) return warnings;
  const ConstantTable changed = changed_constants(info.constants);
  for (const auto& [name, value] : changed) {
    const std::unique_ptr<Task> task = without(entry->base, changed, name);
    if (task == nullptr) continue;
    for (std::size_t i = 0; i < info.options.size(); ++i) {
      const TaskOptionSpec& option = info.options[i];
      const TaskOptionSpec& before = task->info().options[i];
      const bool unused = option.value != before.value && option.original == before.original;
      if (unused && option.original && !is_chosen(option, options)) {
        warnings.push_back(warning(name, value, option, options.rules));
      }
    }
  }
  return warnings;
}

}  // namespace engram
