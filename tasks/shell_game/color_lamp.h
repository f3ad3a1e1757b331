// ShellGameColorLampTouch: three coloured balls vanish under three mugs; a lamp then shows the
// colour whose mug has to be touched.
#pragma once

#include <memory>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram::tasks {

// ShellGameColorLampTouch-VLA-v0.
std::unique_ptr<Task> make_shell_game_color_lamp(const RegistryEntry& entry);

}  // namespace engram::tasks
