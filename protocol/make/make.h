// Makes batches of environments from ids, with everything that draws their images.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/batch/batch.h"
#include "tasks/registry.h"

namespace engram {

// A batch of environments of the task with that id. Throws Error: kUnknownId (with the nearest
// id), kUnavailable if its family is not part of this version, kInvalidArgument for a bad option.
std::unique_ptr<Batch> make(std::string_view id, const MakeOptions& options);
std::unique_ptr<Batch> make(std::string_view id, const BatchOptions& options = {});
// Makes a batch with another factory of renderers.
std::unique_ptr<Batch> make(std::string_view id, const MakeOptions& options,
                            RendererFactory renderers);

// A task of a group, and what is its own. Constants, pins and options are added to those of all
// tasks, and win where both have one.
struct TaskShare {
  std::string id;
  int num_envs = 1;
  ConstantTable constants = {};
  std::vector<Pin> pins = {};
  std::vector<TaskOptionValue> task_options = {};
};

// Environments of several tasks, one task behind the other. Environment i of a task has seed + i.
// options: of all tasks; their num_envs does not count. Throws the errors of make().
std::unique_ptr<Batch> make_group(std::span<const TaskShare> tasks, const MakeOptions& options);

// Version of the library, "0.6.0".
const char* version();

}  // namespace engram
