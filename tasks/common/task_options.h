// Options of a family. It declares them once, one after the other; each handle reads its own value.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/task/task.h"

namespace engram::tasks {

// Handle of an option.
class TaskOption {
 public:
  TaskOption() = default;
  explicit TaskOption(std::size_t index) : index_(index) {}

  double value(const Bindings& bindings) const { return bindings.options[index_]; }
  // State of a switch.
  bool is_on(std::span<const double> options) const { return options[index_] != 0; }
  bool is_on(const Bindings& bindings) const { return is_on(bindings.options); }

 private:
  std::size_t index_ = 0;
};

// List builder: describes an option in TaskInfo::options and returns its handle.
class TaskOptions {
 public:
  explicit TaskOptions(std::vector<TaskOptionSpec>& list) : list_(&list) {}

  TaskOption add(TaskOptionSpec about) {
    list_->push_back(std::move(about));
    return TaskOption(list_->size() - 1);
  }
  // Off unless a user turns it on; on in the original's code, where that is `original`.
  TaskOption on_off(std::string name, std::string description, bool original) {
    TaskOptionSpec about;
    about.name = std::move(name);
    about.integer = true;
    about.description = std::move(description);
    if (original) about.original = 1;
    return add(std::move(about));
  }

 private:
  std::vector<TaskOptionSpec>* list_;
};

}  // namespace engram::tasks
