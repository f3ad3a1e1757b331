// The shuffles: after the cue the mugs swap places, and the right one has to be followed.
#pragma once

#include <memory>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram::tasks {

// ShellGameShuffleTouch-VLA-v0 and -Long-VLA-v0.
std::unique_ptr<Task> make_shell_game_shuffle_touch(const RegistryEntry& entry);

// ShellGameShuffleColorLampTouch-VLA-v0 and -Long-VLA-v0.
std::unique_ptr<Task> make_shell_game_shuffle_color_lamp(const RegistryEntry& entry);

}  // namespace engram::tasks
