#include "apps/task_choice.h"

#include <algorithm>
#include <set>

#include "apps/output.h"
#include "protocol/make/constant_warnings.h"
#include "protocol/make/make.h"

namespace engram::apps {
namespace {

// The tasks by name; an unknown one is an error.
std::vector<const RegistryEntry*> named_tasks(const std::vector<std::string>& ids) {
  std::vector<const RegistryEntry*> tasks;
  for (const std::string& id : ids) {
    const RegistryEntry& entry = require_entry(id);
    if (std::find(tasks.begin(), tasks.end(), &entry) == tasks.end()) tasks.push_back(&entry);
  }
  return tasks;
}

}  // namespace

std::vector<const RegistryEntry*> chosen_tasks(const std::vector<std::string>& ids,
                                               const TaskFilter& filter, bool all) {
  const bool filtered = all || filter.any();
  if (!ids.empty() && filtered) {
    throw Error(Error::kInvalidArgument,
                "task ids and --split, --family, --canonical or --all given; one or the other "
                "allowed");
  }
  if (ids.empty() && !filtered) {
    throw Error(Error::kInvalidArgument,
                "no task given; ids, --split, --family, --canonical or --all needed");
  }
  if (!filtered) return named_tasks(ids);

  std::vector<const RegistryEntry*> tasks = select(filter);
  if (!filter.split) {
    std::erase_if(tasks, [](const RegistryEntry* task) { return task->is_rl(); });
  }
  if (tasks.empty()) {
    throw Error(Error::kInvalidArgument, "the filters leave no task; `engram list` shows all");
  }
  return tasks;
}

void warn_of_constants(std::span<const RegistryEntry* const> tasks, const MakeOptions& options) {
  std::set<std::string> known;
  for (const RegistryEntry* task : tasks) {
    for (const std::string& text : constant_warnings(task->id, options)) {
      if (known.insert(text).second) print_warning(text);
    }
  }
}

void warn_of_constants(std::string_view id, const MakeOptions& options) {
  const RegistryEntry* task = &require_entry(id);
  warn_of_constants({&task, 1}, options);
}

}  // namespace engram::apps
