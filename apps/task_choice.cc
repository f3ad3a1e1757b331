#include "apps/task_choice.h"

#include <algorithm>

#include "protocol/batch/make.h"

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
  if (tasks.empty()) {
    throw Error(Error::kInvalidArgument, "the filters leave no task; `engram list` shows all");
  }
  return tasks;
}

}  // namespace engram::apps
