// BunchOfColors, SeqOfColors and ChainOfColors: coloured cubes are shown together or one by one,
// and have to be touched among nine, then the button in the middle pressed (docs/tasks/colors.md).
#pragma once

#include <memory>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram::tasks {

// {Bunch,Seq,Chain}OfColors{3,5,7}-VLA-v0 and -Long-VLA-v0.
std::unique_ptr<Task> make_color_recall(const RegistryEntry& entry);

}  // namespace engram::tasks
