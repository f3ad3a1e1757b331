// ShellGameTouch: a ball vanishes under one of three mugs; that mug has to be touched.
#pragma once

#include <memory>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram::tasks {

// ShellGameTouch-VLA-v0.
std::unique_ptr<Task> make_shell_game_touch(const RegistryEntry& entry);

}  // namespace engram::tasks
