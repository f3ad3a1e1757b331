#include "apps/task_choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/output.h"

namespace engram::apps {
namespace {

// The tasks by name; an unknown or unavailable one is an error.
std::vector<const RegistryEntry*> named_tasks(const std::vector<std::string>& ids) {
  std::vector<const RegistryEntry*> tasks;
  for (const std::string& id : ids) {
    const RegistryEntry& entry = require_entry(id);
    if (!is_implemented(entry)) (void)make_task(id);  // throws, saying why
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
  const std::size_t registered = tasks.size();
  std::erase_if(tasks, [](const RegistryEntry* entry) { return !is_implemented(*entry); });
  if (tasks.empty()) {
    throw Error(Error::kUnavailable,
                fmt::format("{} tasks chosen, none of a family that is part of this version; "
                            "`engram list` shows which are",
                            registered));
  }
  if (tasks.size() < registered) {
    print_error(fmt::format("{} of {} tasks skipped: their families are not part of this version",
                            registered - tasks.size(), registered));
  }
  return tasks;
}

}  // namespace engram::apps
